/* LinuxCNC's Python module `gcode` drops many calls that its interpreter makes to the control: digital outputs,
 * stops, the spindle. This library stands in front of the module, takes those calls and reports them.
 *
 * It has to be loaded, with its symbols global, before the module. Each function carries the C++ symbol of the call
 * that it takes (src/emc/nml_intf/canon.hh of LinuxCNC 2.9). */

#include <stddef.h>
#include <string.h>

enum { INCHES = 1, MILLIMETRES = 2 };

typedef void report_function(const char *call, int number, double value);
typedef void comment_function(const char *text);
typedef void units_function(int units);

static report_function *report_call;
static comment_function *make_comment;
static units_function *pass_units;
static int units = INCHES;

/* Says where reports go, and gives the module's own COMMENT and USE_LENGTH_UNITS. The module announces a new line
 * only when one of its own calls comes, so an empty comment before each report brings the line number up to date. */
void attach(report_function *report, comment_function *comment, units_function *use_length_units)
{
    report_call = report;
    make_comment = comment;
    pass_units = use_length_units;
}

static void say(const char *call, int number, double value)
{
    make_comment("");
    report_call(call, number, value);
}

/* Digital outputs: M62 and M63 with the next motion, M64 and M65 at once. */
void _Z21SET_MOTION_OUTPUT_BITi(int number) { say("output_on_with_motion", number, 0.0); }
void _Z23CLEAR_MOTION_OUTPUT_BITi(int number) { say("output_off_with_motion", number, 0.0); }
void _Z18SET_AUX_OUTPUT_BITi(int number) { say("output_on", number, 0.0); }
void _Z20CLEAR_AUX_OUTPUT_BITi(int number) { say("output_off", number, 0.0); }

/* Stops and the end: M0, M1, M2 or M30, M60. */
void _Z12PROGRAM_STOPv(void) { say("stop", 0, 0.0); }
void _Z21OPTIONAL_PROGRAM_STOPv(void) { say("optional_stop", 0, 0.0); }
void _Z11PROGRAM_ENDv(void) { say("end", 0, 0.0); }
void _Z14PALLET_SHUTTLEv(void) { say("pallet_shuttle", 0, 0.0); }

/* What a knife program never does. */
void _Z23SET_MOTION_OUTPUT_VALUEid(int number, double value) { say("analog_output_with_motion", number, value); }
void _Z20SET_AUX_OUTPUT_VALUEid(int number, double value) { say("analog_output", number, value); }
void _Z23START_SPINDLE_CLOCKWISEii(int number, int wait) { (void)wait; say("spindle_clockwise", number, 0.0); }
void _Z30START_SPINDLE_COUNTERCLOCKWISEii(int number, int wait) { (void)wait; say("spindle_counterclockwise", number, 0.0); }
void _Z14ORIENT_SPINDLEidi(int number, double angle, int mode) { (void)mode; say("spindle_orient", number, angle); }
void _Z22START_SPEED_FEED_SYNCHidb(int number, double feed, _Bool velocity) { (void)velocity; say("spindle_synchronised", number, feed); }
void _Z32START_CUTTER_RADIUS_COMPENSATIONi(int side) { say("cutter_compensation", side, 0.0); }
void _Z11SELECT_TOOLi(int number) { say("select_tool", number, 0.0); }
void _Z7MIST_ONv(void) { say("mist_on", 0, 0.0); }
void _Z8FLOOD_ONv(void) { say("flood_on", 0, 0.0); }
int _Z4WAITiiid(int number, int type, int mode, double timeout)
{
    (void)type;
    (void)mode;
    say("wait_for_input", number, timeout);
    return 0;
}

/* Comments that LinuxCNC executes: (LOGOPEN,...), (LOGAPPEND,...) and (LOG,...) write files. */
void _Z7LOGOPENPc(char *name) { (void)name; say("log_open", 0, 0.0); }
void _Z9LOGAPPENDPc(char *name) { (void)name; say("log_append", 0, 0.0); }
void _Z3LOGPc(char *text) { (void)text; say("log", 0, 0.0); }

/* (py,...) and ;py,... are executed as Python. Here they are only reported. The interpreter itself has one line
 * executed while it comes into being, when nobody can take a report yet. */
int _ZN12PythonPlugin10run_stringEPKcRN5boost6python3api6objectEb(void *plugin, const char *text, void *result, _Bool as_file)
{
    (void)plugin;
    (void)result;
    (void)as_file;
    if (strcmp(text, "from interpreter import this") != 0)
        say("python", 0, 0.0);
    return 0;
}

/* The module pretends that a feed of 1 is always set, so that a G1 before any F would pass. A control starts with
 * none, and refuses; later the interpreter reads back what it has set, in the program's present units. */
static double feed_inches_per_minute;

void set_feed(double inches_per_minute) { feed_inches_per_minute = inches_per_minute; }

double _Z22GET_EXTERNAL_FEED_RATEv(void)
{
    return units == MILLIMETRES ? feed_inches_per_minute * 25.4 : feed_inches_per_minute;
}

void _Z16USE_LENGTH_UNITS11CANON_UNITS(int new_units)
{
    units = new_units;
    pass_units(new_units);
}
