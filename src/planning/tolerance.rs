//! Every epsilon of the planning core, named once, with its reason.

/// A step of U smaller than this, in mm, is no change of direction (domain.md A5).
///
/// It equals the positioning of the platform's knives (Huang et al. 2017, section 1.2.3), so a smaller
/// reversal could not be cut even if it were wanted.
pub const U_REVERSAL_MM: f64 = 0.01;

/// A ply edge that lies this close to the tape's own edge, in mm, *is* the tape's edge and needs no cut.
///
/// A tenth of the positioning of the knives; it absorbs the rounding of coordinates printed with three or
/// more decimals and nothing that a knife could cut.
pub const STRIP_EDGE_MM: f64 = 0.001;

/// Two points closer than this, in mm, are one point. Inputs are printed with six decimals at best.
pub const SAME_POINT_MM: f64 = 1e-6;

/// Default chord tolerance, in mm, to which cut points are thinned out (domain.md A7).
pub const CHORD_MM: f64 = 0.01;

/// What the printed digits of a program may add to the chord tolerance, in mm, in a replay.
///
/// Four decimals round each coordinate by at most 0.00005; the two linear axes together by 0.00007. The rest
/// is room for the sampling of the replay itself.
pub const REPLAY_SLACK_MM: f64 = 0.001;

/// How far a mould point may leave the common plane, in mm, before a ply is no longer flat.
pub const FLAT_MM: f64 = 0.001;

/// How far a course point may leave the straight line through its ends, in mm, before it is no longer straight.
///
/// It is half of the chord tolerance, so that a course that passes can spend the rest on thinning.
pub const STRAIGHT_MM: f64 = 0.005;

/// How far a normal may differ from length 1 before that is reported (it is then scaled).
pub const UNIT_NORMAL: f64 = 1e-6;

/// A normal shorter than this has no direction.
pub const ZERO_NORMAL: f64 = 1e-9;

/// A course is square to its normal if the cosine between them stays below this (0.06 degrees).
pub const SQUARE_COSINE: f64 = 1e-3;

/// A closing step this many times longer than the median step of an outline is reported: the file may be cut short.
pub const LONG_CLOSING_STEP: f64 = 20.0;

/// A blade turn up to this, in degrees, is made along the next segment of a cut instead of at its first point.
///
/// Half of the degree within which a replay wants the blade along the cut (domain.md A9).
pub const BLADE_BLEND_DEG: f64 = 0.5;

/// Largest angle, in degrees, between a blade and its cut that a replay accepts (domain.md A9).
pub const BLADE_ALONG_CUT_DEG: f64 = 1.0;

/// A flat ply of which less than this share lies under its courses is reported. Gaps between tapes of 0.5 mm on
/// 75 mm leave 0.7 % uncovered; a course that was forgotten leaves more.
pub const COVERED_SHARE: f64 = 0.985;

/// The foot of a point on its course is found to this distance along the course, in mm: far below any other error.
pub const FOOT_MM: f64 = 1e-9;

/// How wide a slit in a honeycomb section is, in mm, half of it on either side of the blade's plane (domain.md B3).
///
/// Slits of no width leave chips hanging on slivers once a program is rounded. Two slits that should meet miss each
/// other by what print leaves of two tips (four decimals 0.00014 mm, three 0.0014) and two angles (0.0005 degrees
/// over a reach of 40 mm: 0.0007). Half a kerf covers that twice over.
pub const KERF_MM: f64 = 0.01;

/// How far a slit goes on beyond the reach of the blade, in mm.
///
/// Arms of the published lattices end exactly where they cross their neighbour's slit. Two lines that print has
/// moved by 0.0003 mm, four decimals throughout, cross up to 0.0003 / sin(2 alpha) farther on; this covers swings
/// from one degree.
pub const SLIT_OVERRUN_MM: f64 = 0.01;

/// A blade that enters the part no deeper than this, in mm, is on its contour.
///
/// Three printed decimals move a tip by up to 0.0007 mm; the rest is for its angle.
pub const GOUGE_MM: f64 = 0.001;

/// A planned tip or arm this close to the contour, in mm, is on it: the rounding of interpolation, far below print.
pub const CONTOUR_TOUCH_MM: f64 = 1e-9;

/// The largest distance of a surface from the contour is found to this, in mm.
pub const FARTHEST_MM: f64 = 1e-7;

/// A piece of honeycomb smaller than this, in mm^2, is dust of the slit that cut it off and no chip.
///
/// It is what a sliver of a hundredth of a kerf leaves over 0.01 mm.
pub const SLIVER_MM2: f64 = 1e-6;

/// Stock that hangs together by less than this, in units of 2^-26 mm, is parted: 1.5e-5 mm.
///
/// The overlay may move a crossing by a few units; it is a thousandth of a kerf all the same.
pub const SLIVER_UNITS: i64 = 1 << 10;

/// A corner of stock this close to the border of its tile, in units of 2^-26 mm, lies on it.
///
/// The overlay moves a crossing to a corner within one unit, and within a few where many meet.
pub const TILE_SNAP_UNITS: i64 = 1 << 4;
