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

/// Places of the roll closer than this, in mm, are one place to a knife: a program's last printed digit. Two cuts that
/// are drawn to meet there overlap by more than [`SAME_POINT_MM`] once their corners are rounded to six decimals.
pub const ONE_PLACE_MM: f64 = 1e-4;

/// Default chord tolerance, in mm, to which cut points are thinned out (domain.md A7).
pub const CHORD_MM: f64 = 0.01;

/// The share of the chord tolerance that the turning of a spool may take (domain.md A8); the rest is for thinning.
///
/// Between two places a control moves a driven spool linearly in angle and a carriage linearly in mm, which is no
/// straight cut. Halving this share splits the moves of a cut 1.4 times as often.
pub const SPOOL_SHARE: f64 = 0.2;

/// The share of the chord tolerance that is kept for a blade whose edge lies beside its turning axis: for corners that are
/// rounded off while the tape advances, and for the chords of the axis' way round a corner.
pub const OFFSET_SHARE: f64 = 0.5;

/// What the printed digits of a program may add to the chord tolerance, in mm, in a replay.
///
/// Four decimals round each coordinate by at most 0.00005; the two linear axes together by 0.00007. The rest
/// is room for the sampling of the replay itself.
pub const REPLAY_SLACK_MM: f64 = 0.001;

/// How far a mould point may leave the common plane, in mm, before a ply is no longer flat.
///
/// Of a tilted plane whose points are printed with two decimals, one may lie off it by up to 0.0087 and the one that it is
/// measured from by as much the other way. Seen along the plane's normal nothing moves by that, and a step of 1 mm is
/// shortened by 0.0002.
pub const FLAT_MM: f64 = 0.02;

/// Curves of a drawing are flattened so that no chord leaves its curve by more than this, in mm.
///
/// It is half of the smallest chord tolerance that a job may ask for (0.001 mm), so that thinning still has a say.
pub const CURVE_CHORD_MM: f64 = 0.0005;

/// Ends of curves in a drawing that are this close, in mm, are one end.
///
/// It equals the positioning of the platform's knives. Drawings print ends with four to sixteen digits, so ends that
/// should meet do so to a thousandth; a larger gap is a fault of the drawing and not for us to close.
pub const JOIN_MM: f64 = 0.01;

/// A plane whose normal has a smaller z than this (0.6 degrees from upright) has no upper side.
pub const UPRIGHT_COSINE: f64 = 0.01;

/// How far a course point may leave the straight line through its ends, in mm, before it is no longer straight.
///
/// It is half of the chord tolerance, so that a course that passes can spend the rest on thinning.
pub const STRAIGHT_MM: f64 = 0.005;

/// How far a normal may differ from length 1 before that is reported (it is then scaled).
pub const UNIT_NORMAL: f64 = 1e-6;

/// Normals of places beside each other whose cosine is below this (120 degrees) point against one another. On a mould of
/// 800 mm radius they turn by 44 degrees over two tapes of 300 mm.
pub const OPPOSED_COSINE: f64 = -0.5;

/// A ply and its courses whose sizes differ by more than this factor are hardly in one unit: an inch is
/// 25.4 mm, a metre 1000.
pub const UNLIKE_SIZES: f64 = 20.0;

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

/// Turns of a blade no farther apart than this, in mm, are one corner; a cut longer than this has its blade along it.
///
/// Printed digits turn a cut of this length by 0.3 degrees at most; together with what a plan may leave to
/// turn along a cut that stays within [`BLADE_ALONG_CUT_DEG`].
pub const CORNER_MM: f64 = 0.03;

/// Largest angle, in degrees, between a blade and its cut that a replay accepts (domain.md A9).
pub const BLADE_ALONG_CUT_DEG: f64 = 1.0;

/// A flat ply of which less than this share lies under its courses is reported, and one of which more than the rest lies under
/// several. Gaps between tapes of 0.5 mm on
/// 75 mm leave 0.7 % uncovered; a course that was forgotten leaves more.
pub const COVERED_SHARE: f64 = 0.985;

/// The last step to the foot of a point on its course, in mm: along a mould of any radius that tape is laid on, what the
/// first order of the course's frame leaves out over it is a nanometre, far below any other error.
pub const LAST_STEP_MM: f64 = 1e-3;

/// A tip's lowest allowed place is found to this, in mm: far below any other error.
pub const TIP_SEARCH_MM: f64 = 1e-9;

/// Two places of a robot program closer than this, in mm, are one place.
///
/// Four decimals round each of three coordinates by at most 0.00005; a difference of two by 0.00018. The rest is
/// room for the foreign programs that print three decimals.
pub const PRINTED_MM: f64 = 0.001;

/// Two postures of a robot program closer than this, in degrees, are one posture.
///
/// Four decimals round each of three angles by at most 0.00005; the rest as of [`PRINTED_MM`].
pub const PRINTED_DEG: f64 = 0.001;

/// How far a blade may lie out of the plane of its cut, or its swing from the planned one, in degrees.
///
/// It is what printed angles leave after three turns; over a blade of 50 mm it is 0.005 mm.
pub const BLADE_PLANE_DEG: f64 = 0.005;

/// A programmed speed may exceed its limit by this factor: half of the last printed digit (0.001 mm/s) at 5 mm/s.
pub const SPEED_RATIO: f64 = 1.0 + 1e-4;

/// Nearer to a singularity than this, in degrees, a program is still run but said to be near one: a base that was
/// measured a few millimetres off would change the speed of the wrist noticeably.
pub const SINGULAR_WARNING_DEG: f64 = 5.0;

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

/// Sine of axis 5 below which axis 4 of a straight wrist has no angle of its own.
///
/// Turning axis 4 as one likes then turns the flange's axes by no more than this, in rad: a hundredth of a
/// micrometre in 10 m.
pub const WRIST_POLE_SINE: f64 = 1e-12;

/// A path that comes this near to a singularity, in degrees, cannot be followed through it.
///
/// An axis would have to turn 3,000 times as fast as the tool, and on which branch the arm leaves is chance.
pub const SINGULAR_DEG: f64 = 0.02;

/// No joint moves by more than this, in degrees, between two instants at which a path is looked at.
///
/// It is a bound that holds for the worst of directions; what joints really move is about half of it. Where a rate
/// peaks, as axis 4 does at a near wrist singularity, it falls with the squared cosine of the axis' own way; the peak
/// is thus missed by 1 - cos^2(5 deg / 2) = 0.2 % at the very most.
pub const JOINT_STEP_DEG: f64 = 5.0;

/// Near its limit no joint moves by more than this, in degrees, between two instants at which a path is looked at;
/// so it cannot be beyond it unseen by more than half of this.
pub const LIMIT_STEP_DEG: f64 = 0.2;

/// Between the samples of a joint curve straight lines miss the joints by no more than this, in degrees: less than
/// the width of a line in a drawing.
pub const JOINT_CURVE_DEG: f64 = 0.1;

/// A turn this near to 180 degrees, in degrees, may go either way round: printed angles of both ends may decide it.
pub const HALF_TURN_DEG: f64 = 0.01;

/// How far from where the arm is a straight move may begin, in mm.
///
/// Axis values printed with three decimals put a tool 4 m away by 0.035 mm off per axis at worst.
pub const PATH_GAP_MM: f64 = 0.05;

/// How far from the tool's orientation a straight move may begin, in degrees; as [`PATH_GAP_MM`].
pub const PATH_GAP_DEG: f64 = 0.01;

/// A joint may be beyond its limit by this, in degrees, or its speed by this ratio: what computing adds to a joint
/// that stands at its limit, and far below the last printed digit.
pub const JOINT_SLACK: f64 = 1e-9;

/// A limit of the published honeycomb model is kept up to this share beyond it: angles that come in degrees and
/// steps that equal 2 h tan(alpha) round by 1e-15, and no job is printed with more than nine digits.
pub const MODEL_LIMIT: f64 = 1e-9;

/// A shortest time is proved to this share of it: a hundredth of what is promised (1e-6), and a hundred times what
/// the interior point method leaves.
pub const OPTIMUM_GAP: f64 = 1e-8;

/// A limit holds the optimum of the published model if it has at least this
/// multiplier, d ln T / d ln limit. What the barrier leaves on the others is below 1e-10.
pub const ACTIVE_MULTIPLIER: f64 = 1e-7;

/// A piece that is nowhere as wide as this, in mm, is a sliver: an eighth of an inch, the narrowest tape that is slit
/// for laying. No head holds and no roller presses what is narrower.
pub const SLIVER_MM: f64 = 3.175;

/// Two neighbouring outlines whose ends are nowhere farther apart than this share of the chord tolerance may share one
/// cut. The cut is then made as one of them wants it; the other share is left for making it monotone and thinning it.
pub const SHARED_CUT_SHARE: f64 = 0.5;
