"""Runs NC programs through LinuxCNC's own interpreter and says what a control with nine axes would do.

Started by target/linuxcnc/interpreter (see `prepare`). A request is one line of JSON on standard input, a string:
the program's text. The answer is one line of JSON on standard output: {"events": [...], "error": null} where the
error, if there is one, is {"line", "message"} and the events are those before it. Every event has "line" (from 1)
and "call"; a move has "to" (X Y Z A B C U V W in mm and degrees), a feed also "rate" (mm or degrees a minute) and
"mode", a dwell "seconds", an output "number".
"""

import ctypes
import glob
import json
import os
import sys
import tempfile
import time

MM_PER_INCH = 25.4  # The module speaks inches, whatever the program does.
ROTARY = range(3, 6)  # A B C
NINE_AXES = 0x1FF
# Time on the processor for a program, and for each of its lines more (40,000 lines take a second).
PATIENCE_S = 3.0
PATIENCE_PER_LINE_S = 1e-3

REPORT = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_int, ctypes.c_double)

# The interpreter's own remarks: the only place where it says the feed mode at the moment when it changes.
FEED_MODES = {
    "interpreter: feed mode set to inverse time": "inverse_time",
    "interpreter: feed mode set to units per minute": "per_minute",
    "interpreter: feed mode set to units per revolution": "per_revolution",
}


def millimetres(values):
    return [v if i in ROTARY else v * MM_PER_INCH for i, v in enumerate(values)]


class Control:
    """The control as the interpreter sees it: takes its calls and writes them down."""

    def __init__(self, parameter_file, patience, remember_feed):
        self.parameter_file = parameter_file
        self.events = []
        self.line = 0
        self.remember_feed = remember_feed
        self.set_feed_rate(0.0)
        self.mode = "per_minute"
        self.deadline = time.process_time() + patience

    def note(self, call, **details):
        self.events.append({"line": self.line, "call": call, **details})

    def report(self, call, number, value):
        self.note(call.decode("ascii"), number=number, value=value)

    # Motion.

    def next_line(self, state):
        self.line = state.sequence_number

    def straight_traverse(self, *position):
        self.note("rapid", to=millimetres(position))

    def straight_feed(self, *position):
        self.note("feed", to=millimetres(position), rate=self.rate, mode=self.mode)

    def set_feed_rate(self, inches_per_minute):
        self.rate = inches_per_minute * MM_PER_INCH
        self.remember_feed(inches_per_minute)

    def dwell(self, seconds):
        self.note("dwell", seconds=seconds)

    def comment(self, text):
        self.mode = FEED_MODES.get(text, self.mode)

    # What moves the origin. Programs are compared in program coordinates, so only zeros may pass in silence.

    def set_g5x_offset(self, _number, *offset):
        self.note_unless_zero("origin", offset)

    def set_g92_offset(self, *offset):
        self.note_unless_zero("origin_shift", offset)

    def set_xy_rotation(self, angle):
        self.note_unless_zero("rotation", [angle])

    def tool_offset(self, *offset):
        self.note_unless_zero("tool_offset", offset)

    def note_unless_zero(self, call, values):
        if any(values):
            self.note(call)

    # What a knife program never does.

    def arc_feed(self, *_):
        self.note("arc")

    def straight_probe(self, *_):
        self.note("probe")

    def rigid_tap(self, *_):
        self.note("rigid_tap")

    def change_tool(self, number):
        self.note("change_tool", number=number)

    def user_defined_function(self, number, _p, _q):
        self.note("user_m_code", number=100 + number)

    def message(self, _text):
        self.note("message")

    # What the interpreter asks.

    def get_axis_mask(self):
        return NINE_AXES

    def get_tool(self, number):
        return (number,) + (0.0,) * 12 + (0,)

    def get_block_delete(self):
        return False

    def get_external_angular_units(self):
        return 1.0

    def get_external_length_units(self):
        return 1.0

    def check_abort(self):
        return time.process_time() > self.deadline

    def set_traverse_rate(self, _rate):
        pass

    def set_plane(self, _plane):
        pass


class Interpreter:
    """LinuxCNC's module `gcode` with canon.so in front of it."""

    def __init__(self, room, folder):
        self.folder = folder
        self.control = None
        write_machine(folder)
        self.canon = ctypes.PyDLL(os.path.join(room, "canon.so"), mode=ctypes.RTLD_GLOBAL)
        self.canon.set_feed.argtypes = [ctypes.c_double]
        sys.path.append(only(os.path.join(room, "usr/lib/python3*/dist-packages")))
        import gcode

        self.gcode = gcode
        self.report = REPORT(lambda *call: self.control.report(*call))
        module = ctypes.PyDLL(gcode.__file__)
        own_comment = getattr(module, "_Z7COMMENTPKc")
        own_units = getattr(module, "_Z16USE_LENGTH_UNITS11CANON_UNITS")
        self.canon.attach(self.report, own_comment, own_units)

    def run(self, program):
        path = os.path.join(self.folder, "program.ngc")
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.write(program)
        patience = PATIENCE_S + PATIENCE_PER_LINE_S * program.count("\n")
        self.control = Control(write_parameters(self.folder), patience, self.canon.set_feed)
        return {"error": self.parse(path), "events": self.control.events}

    def parse(self, path):
        try:
            result, _ = self.gcode.parse(path, self.control, "", "")
        except KeyboardInterrupt:
            return {"line": self.control.line, "message": "it has no end"}
        if result <= self.gcode.MIN_ERROR:
            return None
        # The module's own line number is one too high for what fails while a line is read.
        return {"line": self.control.line, "message": self.gcode.strerror(result)}


def only(pattern):
    (path,) = glob.glob(pattern)
    return path


def write_machine(folder):
    """The least that the interpreter wants to find: nine axes in millimetres and degrees, no tools."""
    path = os.path.join(folder, "machine.ini")
    with open(path, "w", encoding="ascii") as file:
        file.write(
            "[EMC]\nVERSION = 1.1\n"
            "[RS274NGC]\nPARAMETER_FILE = parameters\n"
            "[TRAJ]\nCOORDINATES = X Y Z A B C U V W\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n"
        )
    os.environ["INI_FILE_NAME"] = path
    os.chdir(folder)


def write_parameters(folder):
    """Parameters as on a new machine: the interpreter saves what a program leaves behind, origins too."""
    path = os.path.join(folder, "parameters")
    with open(path, "w", encoding="ascii") as file:
        file.write("5220\t1.0\n")
    return path


def main():
    # Whatever the interpreter prints goes to standard error; answers alone go to standard output.
    answers = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)
    with tempfile.TemporaryDirectory(prefix="linuxcnc.") as folder:
        interpreter = Interpreter(os.path.abspath(sys.argv[1]), folder)
        for request in sys.stdin:
            json.dump(interpreter.run(json.loads(request)), answers)
            answers.write("\n")
            answers.flush()


main()
