//! Words of KRL that mean something to this reader, or that it refuses by name.

/// Words that move the robot, now or together with other lines.
const MOTIONS: [&str; 27] = [
    "LIN",
    "PTP",
    "LIN_REL",
    "PTP_REL",
    "SLIN",
    "SPTP",
    "SLIN_REL",
    "SPTP_REL",
    "CIRC",
    "CIRC_REL",
    "SCIRC",
    "SCIRC_REL",
    "SPL",
    "SPL_REL",
    "SPLINE",
    "PTP_SPLINE",
    "ENDSPLINE",
    "ASYPTP",
    "ASYCONT",
    "ASYSTOP",
    "ASYCANCEL",
    "BRAKE",
    "RESUME",
    "MOVE_EMI",
    "TIME_BLOCK",
    "CONST_VEL",
    "STOP",
];

/// Words whose lines decide which lines come next.
const BRANCHES: [&str; 18] = [
    "FOR",
    "ENDFOR",
    "WHILE",
    "ENDWHILE",
    "LOOP",
    "ENDLOOP",
    "REPEAT",
    "UNTIL",
    "SWITCH",
    "CASE",
    "DEFAULT",
    "ENDSWITCH",
    "GOTO",
    "EXIT",
    "SKIP",
    "ENDSKIP",
    "DEFFCT",
    "ENDFCT",
];

/// Whether a word, in any case, is one that moves the robot.
pub(super) fn is_motion(word: &str) -> bool {
    MOTIONS.iter().any(|motion| motion.eq_ignore_ascii_case(word))
}

/// Whether a word, in any case, decides which lines come next; IF, ELSE and ENDIF are read.
pub(super) fn is_branch(word: &str) -> bool {
    BRANCHES.iter().any(|branch| branch.eq_ignore_ascii_case(word))
}
