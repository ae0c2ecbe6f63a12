//! Robot arms as data: lengths, joints, limits and speeds; four of them built in, and the way in for others.
//!
//! An arm is described by the parameters of Brandstötter, Angerer and Hofbaur 2014 (OPW: ortho-parallel basis,
//! spherical wrist). With all model angles 0 it stands straight up: axis 2 lies `a1` before and `b` beside axis 1
//! and `c1` above the foot, axis 3 `c2` above axis 2, axis 4 `a2` before axis 3, the centre of the wrist `c3` above
//! axis 3 and the flange `c4` above the centre. A model angle is `sign * joint - offset`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::planning::document::files::{FileReference, Files};
use crate::planning::document::shape::{Shape, required};
use crate::planning::document::{self};
use crate::planning::finding::{Code, Finding};

/// A six-axis arm with a spherical wrist.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    /// Its name.
    pub name: String,
    /// Always `six-axis-arm`.
    pub kind: String,
    /// Its lengths.
    pub geometry: Geometry,
    /// Its joints from the foot, A1 to A6.
    pub joints: [Joint; 6],
}

/// The lengths of an arm (OPW parameters).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Axis 2 before axis 1.
    pub a1_mm: f64,
    /// Axis 4 before axis 3; negative where it lies above it when the forearm is level.
    pub a2_mm: f64,
    /// Axis 2's plane beside axis 1.
    pub b_mm: f64,
    /// Axis 2 above the foot.
    pub c1_mm: f64,
    /// Axis 3 above axis 2.
    pub c2_mm: f64,
    /// The centre of the wrist above axis 3.
    pub c3_mm: f64,
    /// The flange above the centre of the wrist.
    pub c4_mm: f64,
}

/// A joint.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// 1 or -1: whether the joint turns as the model does.
    pub sign: i8,
    /// What the model angle lacks at joint angle 0.
    pub offset_deg: f64,
    /// The smallest angle.
    pub min_deg: f64,
    /// The largest angle.
    pub max_deg: f64,
    /// The largest speed.
    pub max_speed_deg_s: f64,
}

/// The arms that a job can name.
#[derive(Debug, Clone)]
pub struct Catalogue(BTreeMap<String, Arm>);

/// An arm by name, in a file, or a whole one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ArmReference {
    /// A built-in or registered arm.
    Named(String),
    /// An arm in a file of its own.
    File(FileReference),
    /// An arm of the job's own.
    Inline(Box<Arm>),
}

/// The KUKA KR 210 family (domain.md B5; public descriptions kroshu/kuka_robot_descriptions and
/// ros-industrial/kuka_experimental).
const KR_210: [&str; 4] = [
    include_str!("arms/kr210-r3100-2.json"),
    include_str!("arms/kr210-r2700-2.json"),
    include_str!("arms/kr210-r3100-ultra.json"),
    include_str!("arms/kr210-l150.json"),
];

impl Catalogue {
    /// The built-in arms.
    ///
    /// # Panics
    /// Never: the built-in arms are part of the source and a test reads them.
    #[must_use]
    pub fn built_in() -> Self {
        let arms = KR_210.map(|text| {
            let arm: Arm = serde_json::from_str(text).expect("a built-in arm fits its own type");
            (arm.name.clone(), arm)
        });
        Self(BTreeMap::from(arms))
    }

    /// Adds an arm; one of the same name is replaced.
    ///
    /// # Errors
    /// Every fault of the arm.
    pub fn insert(&mut self, arm: Arm) -> Result<(), Vec<Finding>> {
        checked(&arm, "")?;
        self.0.insert(arm.name.clone(), arm);
        Ok(())
    }

    /// The arm of that name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Arm> {
        self.0.get(name)
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }
}

/// Resolves a job's arm: looks up its name, reads its file, or takes the arm that stands in the job. None if it stands
/// in a file and there are no `files`: that is for who only checks a document.
///
/// # Errors
/// `UnknownMachine`, `UnknownFile`, or every fault of the arm, with pointers below `at`; those of a file with its name
/// and the pointer within it, as `NAME#/geometry/c2_mm`.
pub fn resolve(
    reference: &ArmReference,
    catalogue: &Catalogue,
    files: Option<&Files>,
    at: &str,
) -> Result<Option<Arm>, Vec<Finding>> {
    match reference {
        ArmReference::Inline(arm) => checked(arm, at).map(|()| Some((**arm).clone())),
        ArmReference::Named(name) => catalogue.get(name).cloned().map(Some).ok_or_else(|| {
            let known: Vec<_> = catalogue.names().collect();
            let message = format!("no arm of that name; known: {}", known.join(", "));
            vec![Finding::error(Code::UnknownMachine, at, message)]
        }),
        ArmReference::File(FileReference { file }) => {
            files.map(|files| of_file(file, files.get(file), at)).transpose()
        }
    }
}

fn of_file(name: &str, bytes: Option<&[u8]>, at: &str) -> Result<Arm, Vec<Finding>> {
    let Some(bytes) = bytes else {
        let message = format!("{name} was not sent with the job");
        return Err(vec![Finding::error(Code::UnknownFile, format!("{at}/file"), message)]);
    };
    if bytes.len() > LARGEST_FILE {
        let message = format!("has {} bytes; a file with an arm has at most {LARGEST_FILE}", bytes.len());
        return Err(vec![Finding::error(Code::OutOfRange, name, message)]);
    }
    // Some editors put a byte order mark in front, which JSON does not have.
    read(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).map_err(|faults| within_file(name, faults))
}

fn within_file(name: &str, faults: Vec<Finding>) -> Vec<Finding> {
    let place = |at: &str| if at.is_empty() { name.to_owned() } else { format!("{name}#{at}") };
    faults.into_iter().map(|fault| Finding { at: place(&fault.at), ..fault }).collect()
}

/// Reads an arm from its own JSON text.
///
/// # Errors
/// Every fault of structure, type and number at once, each with its JSON pointer.
pub fn read(text: &[u8]) -> Result<Arm, Vec<Finding>> {
    let value = document::parse(text).map_err(|fault| vec![fault])?;
    let faults = ARM.faults(&value, "");
    if !faults.is_empty() {
        return Err(faults);
    }
    // A fault here means that the shape and the type disagree.
    let arm: Arm = serde_json::from_value(value)
        .map_err(|error| vec![Finding::error(Code::WrongType, "", error.to_string())])?;
    checked(&arm, "").map(|()| arm)
}

/// Checks what a shape cannot say: an arm may have been made without one.
///
/// # Errors
/// Every fault, with pointers below `at`.
pub fn checked(arm: &Arm, at: &str) -> Result<(), Vec<Finding>> {
    let mut faults = Vec::new();
    check_lengths(&arm.geometry, &format!("{at}/geometry"), &mut faults);
    for (index, joint) in arm.joints.iter().enumerate() {
        check_joint(joint, &format!("{at}/joints/{index}"), &mut faults);
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// The largest file with an arm in bytes: fifty times what an arm takes, written generously.
const LARGEST_FILE: usize = 64 * 1024;
/// The longest length of an arm in mm: ten times that of any that is built.
const LONGEST_MM: f64 = 50_000.0;
/// The shortest link in mm: below it an arm is no arm, and the angles of its triangle lose their digits.
const SHORTEST_LINK_MM: f64 = 1.0;
/// The largest joint angle or offset in degrees: ten turns.
const LARGEST_DEG: f64 = 3_600.0;
/// The largest joint speed in deg/s: far above any arm's.
const FASTEST_DEG_S: f64 = 100_000.0;

const LENGTH: Shape = Shape::Number { min: -LONGEST_MM, max: LONGEST_MM };
const ANGLE: Shape = Shape::Number { min: -LARGEST_DEG, max: LARGEST_DEG };
const JOINT: Shape = Shape::Object(&[
    required("sign", Shape::Integer { min: -1, max: 1 }),
    required("offset_deg", ANGLE),
    required("min_deg", ANGLE),
    required("max_deg", ANGLE),
    required("max_speed_deg_s", Shape::Positive { max: FASTEST_DEG_S }),
]);

/// The shape of an arm.
pub const ARM: Shape = Shape::Object(&[
    required("name", Shape::Text { max_chars: 64 }),
    required("kind", Shape::Word(&["six-axis-arm"])),
    required(
        "geometry",
        Shape::Object(&[
            required("a1_mm", LENGTH),
            required("a2_mm", LENGTH),
            required("b_mm", LENGTH),
            required("c1_mm", LENGTH),
            required("c2_mm", Shape::Number { min: SHORTEST_LINK_MM, max: LONGEST_MM }),
            required("c3_mm", LENGTH),
            required("c4_mm", Shape::Number { min: 0.0, max: LONGEST_MM }),
        ]),
    ),
    required("joints", Shape::Array { item: &JOINT, min: 6, max: 6 }),
]);

fn check_lengths(geometry: &Geometry, at: &str, faults: &mut Vec<Finding>) {
    let Geometry { a1_mm, a2_mm, b_mm, c1_mm, c2_mm, c3_mm, c4_mm } = *geometry;
    let lengths = [
        ("a1_mm", a1_mm, -LONGEST_MM),
        ("a2_mm", a2_mm, -LONGEST_MM),
        ("b_mm", b_mm, -LONGEST_MM),
        ("c1_mm", c1_mm, -LONGEST_MM),
        ("c2_mm", c2_mm, SHORTEST_LINK_MM),
        ("c3_mm", c3_mm, -LONGEST_MM),
        ("c4_mm", c4_mm, 0.0),
    ];
    for (name, value, least) in lengths {
        within(value, least, LONGEST_MM, &format!("{at}/{name}"), faults);
    }
    // A NaN was reported above, and compares with nothing.
    if a2_mm.hypot(c3_mm) < SHORTEST_LINK_MM {
        let message = "the forearm has no length: a2_mm and c3_mm must not both be 0";
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/c3_mm"), message));
    }
}

fn check_joint(joint: &Joint, at: &str, faults: &mut Vec<Finding>) {
    if joint.sign.abs() != 1 {
        let message = format!("is {}; a joint's sign is 1 or -1", joint.sign);
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/sign"), message));
    }
    for (name, value) in
        [("offset_deg", joint.offset_deg), ("min_deg", joint.min_deg), ("max_deg", joint.max_deg)]
    {
        within(value, -LARGEST_DEG, LARGEST_DEG, &format!("{at}/{name}"), faults);
    }
    if joint.min_deg >= joint.max_deg {
        let message =
            format!("is {}; it must be smaller than max_deg, which is {}", joint.min_deg, joint.max_deg);
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/min_deg"), message));
    }
    let speed = joint.max_speed_deg_s;
    if !(speed > 0.0 && speed <= FASTEST_DEG_S) {
        let message = format!("is {speed}; it must be above 0 and at most {FASTEST_DEG_S}");
        faults.push(Finding::error(Code::OutOfRange, format!("{at}/max_speed_deg_s"), message));
    }
}

fn within(value: f64, least: f64, most: f64, at: &str, faults: &mut Vec<Finding>) {
    if !(least..=most).contains(&value) {
        let message = format!("is {value}; it must lie between {least} and {most}");
        faults.push(Finding::error(Code::OutOfRange, at, message));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use serde_json::{Value, json};

    fn r3100() -> Value {
        serde_json::from_str(KR_210[0]).unwrap()
    }

    fn faults_of(value: &Value) -> Vec<(Code, String)> {
        let faults = read(value.to_string().as_bytes()).unwrap_err();
        faults.into_iter().map(|fault| (fault.code, fault.at)).collect()
    }

    #[test]
    fn the_built_in_arms_are_valid_and_go_by_their_names() {
        for text in KR_210 {
            let arm = read(text.as_bytes()).unwrap();
            assert_eq!(Catalogue::built_in().get(&arm.name), Some(&arm));
            assert_eq!(serde_json::to_value(&arm).unwrap()["name"], json!(arm.name));
        }
        let names = ["kr210-l150", "kr210-r2700-2", "kr210-r3100-2", "kr210-r3100-ultra"];
        assert_eq!(Catalogue::built_in().names().collect::<Vec<_>>(), names);
    }

    #[test]
    fn the_limits_and_speeds_are_those_of_the_sources() {
        let arms = Catalogue::built_in();
        let limits = |name: &str, joint: usize| {
            let joint = arms.get(name).unwrap().joints[joint];
            (joint.min_deg, joint.max_deg)
        };
        assert_eq!(limits("kr210-r3100-2", 4), (-122.5, 122.5));
        assert_eq!(limits("kr210-r2700-2", 4), (-125.0, 125.0));
        assert_eq!(limits("kr210-r3100-ultra", 2), (-120.0, 155.0));
        assert_eq!(limits("kr210-l150", 1), (-135.0, -5.0));
        let speeds = arms.get("kr210-r3100-ultra").unwrap().joints.map(|joint| joint.max_speed_deg_s);
        assert_eq!(speeds, [105.4, 101.4, 107.1, 135.8, 129.5, 206.3]);
    }

    #[rstest]
    #[case::order("/joints/1/min_deg", json!(0), "/joints/1/min_deg", Code::OutOfRange)]
    #[case::sign("/joints/2/sign", json!(0), "/joints/2/sign", Code::OutOfRange)]
    #[case::half_a_sign("/joints/2/sign", json!(0.5), "/joints/2/sign", Code::WrongType)]
    #[case::still("/joints/5/max_speed_deg_s", json!(0), "/joints/5/max_speed_deg_s", Code::OutOfRange)]
    #[case::no_arm("/geometry/c2_mm", json!(0), "/geometry/c2_mm", Code::OutOfRange)]
    #[case::huge("/geometry/a1_mm", json!(1e300), "/geometry/a1_mm", Code::OutOfRange)]
    #[case::kind("/kind", json!("tape-cutter"), "/kind", Code::UnknownValue)]
    #[case::text("/geometry/b_mm", json!("0"), "/geometry/b_mm", Code::WrongType)]
    fn a_fault_of_an_arm_is_named(
        #[case] field: &str,
        #[case] value: Value,
        #[case] at: &str,
        #[case] code: Code,
    ) {
        let mut arm = r3100();
        *arm.pointer_mut(field).unwrap() = value;
        assert_eq!(faults_of(&arm), [(code, at.to_owned())]);
    }

    #[test]
    fn a_forearm_of_no_length_missing_and_unknown_fields_are_refused() {
        let mut arm = r3100();
        arm["geometry"]["a2_mm"] = json!(0);
        arm["geometry"]["c3_mm"] = json!(0.5);
        assert_eq!(faults_of(&arm), [(Code::OutOfRange, "/geometry/c3_mm".to_owned())]);
        let mut arm = r3100();
        arm["joints"].as_array_mut().unwrap().pop();
        arm["payload_kg"] = json!(210);
        let expected =
            [(Code::WrongCount, "/joints".to_owned()), (Code::UnknownField, "/payload_kg".to_owned())];
        assert_eq!(faults_of(&arm), expected);
    }

    #[test]
    fn a_nan_that_no_document_can_hold_is_refused_too() {
        let mut arm = Catalogue::built_in().get("kr210-l150").unwrap().clone();
        arm.geometry.c3_mm = f64::NAN;
        arm.joints[3].max_deg = f64::INFINITY;
        arm.joints[4].max_speed_deg_s = f64::NAN;
        let faults = checked(&arm, "/robot").unwrap_err();
        let places: Vec<_> = faults.iter().map(|fault| fault.at.as_str()).collect();
        let expected =
            ["/robot/geometry/c3_mm", "/robot/joints/3/max_deg", "/robot/joints/4/max_speed_deg_s"];
        assert_eq!(places, expected);
        assert!(Catalogue::built_in().insert(arm).is_err());
    }

    #[test]
    fn an_arm_of_ones_own_is_taken_and_an_unknown_name_is_answered_with_the_known_ones() {
        let catalogue = Catalogue::built_in();
        let reference: ArmReference = serde_json::from_value(r3100()).unwrap();
        assert_eq!(resolve(&reference, &catalogue, None, "").unwrap().unwrap().name, "kr210-r3100-2");
        let unknown = ArmReference::Named("kr6".to_owned());
        let faults = resolve(&unknown, &catalogue, None, "/input/cell/robot").unwrap_err();
        assert_eq!((faults[0].code, faults[0].at.as_str()), (Code::UnknownMachine, "/input/cell/robot"));
        assert!(faults[0].message.contains("kr210-l150"));
    }

    fn of(bytes: &[u8]) -> Result<Arm, Vec<(Code, String)>> {
        let mut files = Files::default();
        files.insert("my-arm.json".to_owned(), bytes.to_vec()).unwrap();
        let reference: ArmReference = serde_json::from_value(json!({"file": "my-arm.json"})).unwrap();
        let found = resolve(&reference, &Catalogue::built_in(), Some(&files), "/input/cell/robot");
        found
            .map(Option::unwrap)
            .map_err(|faults| faults.into_iter().map(|fault| (fault.code, fault.at)).collect())
    }

    #[test]
    fn an_arm_in_a_file_is_the_same_as_one_in_the_job() {
        let mut text = r3100().to_string().into_bytes();
        assert_eq!(of(&text).unwrap(), *Catalogue::built_in().get("kr210-r3100-2").unwrap());
        text.splice(0..0, *b"\xef\xbb\xbf");
        assert!(of(&text).is_ok(), "a byte order mark is no fault");
    }

    #[test]
    fn a_file_that_is_not_looked_at_yet_is_no_fault_and_one_that_is_not_there_is() {
        let reference = ArmReference::File(FileReference { file: "my-arm.json".to_owned() });
        assert_eq!(resolve(&reference, &Catalogue::built_in(), None, "/r"), Ok(None));
        let faults = resolve(&reference, &Catalogue::built_in(), Some(&Files::default()), "/r").unwrap_err();
        assert_eq!((faults[0].code, faults[0].at.as_str()), (Code::UnknownFile, "/r/file"));
    }

    #[test]
    fn every_fault_of_a_file_is_named_with_the_file_and_its_place_within() {
        let mut arm = r3100();
        arm["geometry"]["c2_mm"] = json!(0);
        arm["joints"][3]["sign"] = json!("left");
        arm["payload_kg"] = json!(210);
        let expected = [
            (Code::OutOfRange, "my-arm.json#/geometry/c2_mm".to_owned()),
            (Code::WrongType, "my-arm.json#/joints/3/sign".to_owned()),
            (Code::UnknownField, "my-arm.json#/payload_kg".to_owned()),
        ];
        assert_eq!(of(arm.to_string().as_bytes()).unwrap_err(), expected);
        let mut reversed = r3100();
        reversed["joints"][0]["min_deg"] = json!(190);
        let expected = [(Code::OutOfRange, "my-arm.json#/joints/0/min_deg".to_owned())];
        assert_eq!(of(reversed.to_string().as_bytes()).unwrap_err(), expected);
    }

    #[rstest]
    #[case::empty(b"", Code::InvalidJson)]
    #[case::cut_short(b"{\"name\": \"x", Code::InvalidJson)]
    #[case::no_text(b"\xff\xfe\x00", Code::InvalidJson)]
    #[case::a_name(b"\"kr210-l150\"", Code::WrongType)]
    #[case::another_file(b"{\"file\": \"x.json\"}", Code::MissingField)]
    fn a_file_that_is_no_arm_is_refused(#[case] bytes: &[u8], #[case] code: Code) {
        let faults = of(bytes).unwrap_err();
        assert_eq!(faults[0].0, code);
        assert!(faults.iter().all(|(_, at)| at.starts_with("my-arm.json")), "{faults:?}");
    }

    #[test]
    fn hostile_files_are_refused_by_their_size_depth_and_numbers() {
        let mut large = r3100().to_string().into_bytes();
        large.resize(LARGEST_FILE + 1, b' ');
        assert_eq!(of(&large).unwrap_err(), [(Code::OutOfRange, "my-arm.json".to_owned())]);
        large.truncate(LARGEST_FILE);
        assert!(of(&large).is_ok());
        let deep = "[".repeat(LARGEST_FILE);
        assert_eq!(of(deep.as_bytes()).unwrap_err(), [(Code::TooDeep, "my-arm.json".to_owned())]);
        let endless = r3100().to_string().replace("1350", "1e999");
        assert_eq!(of(endless.as_bytes()).unwrap_err()[0].0, Code::InvalidNumber);
    }
}
