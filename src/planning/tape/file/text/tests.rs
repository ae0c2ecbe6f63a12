use proptest::prelude::*;

use super::*;

/// Code and place of each fault.
fn found<T>(read: Result<T, Vec<Finding>>) -> Vec<(Code, String)> {
    read.err().unwrap_or_default().into_iter().map(|fault| (fault.code, fault.at)).collect()
}

fn faults(list: &[(Code, &str)]) -> Vec<(Code, String)> {
    list.iter().map(|(code, at)| (*code, (*at).to_owned())).collect()
}

#[test]
fn any_usual_way_of_writing_an_outline_is_read() {
    let expected = [[0.0, 0.5, 0.0], [1.0, -2e-3, 0.0], [3.0, 4.0, 5.0]];
    for text in [
        "0 .5 0\n1 -2e-3 0\n3 4 5\n",
        "0,0.5,0\r\n1, -0.002 ,0\r\n3,4,+5",
        "\u{feff}# outline\n\n  0\t0.5  0 # first\n\r\n1 -2E-3 0\n#\n3. 4 5   ",
        "loop\n0 0.5 0\n1 -2e-3 0\n3 4 5",
        "LOOP # the only one\n0 0.5 0\n1 -2e-3 0\n3 4 5",
    ] {
        let loops = read_loops("b.txt", text.as_bytes()).unwrap();
        assert_eq!(loops.len(), 1, "{text:?}");
        assert_eq!(loops[0].points, expected, "{text:?}");
    }
}

#[test]
fn a_word_begins_each_further_loop_and_every_point_knows_its_line() {
    let loops = read_loops("b.txt", b"# x\n0 0 0\n\n1 0 0\nloop\n5 5 5\n loop \nloop\n6 6 6\n").unwrap();
    let expected = [(2, vec![2, 4]), (5, vec![6]), (7, vec![]), (8, vec![9])];
    assert_eq!(loops.iter().map(|read| (read.line, read.lines.clone())).collect::<Vec<_>>(), expected);
    assert_eq!(read_loops("b.txt", b"").unwrap(), [ReadLoop { line: 1, ..ReadLoop::default() }]);
    assert_eq!(read_loops("b.txt", b"loop\nloop\n").unwrap().len(), 2, "an empty loop is not passed over");
}

#[test]
fn every_line_that_is_no_point_is_a_fault_with_its_number() {
    let text = b"0 0 0\n1 2\n1 2 3 4\n1,2 3\n1,,3\nnan 0 0\n0 inf 0\n0 0 1e9\n1e400 0 0\n0;0;0\nhole\nloop 2\n1 0x2 3\n1 2 3,\n\xff\xfe 0 0\n0 0 0 # \xff\n";
    let expected = [
        (Code::WrongCount, "b.txt:2"),
        (Code::WrongCount, "b.txt:3"),
        (Code::WrongType, "b.txt:4"),
        (Code::WrongType, "b.txt:5"),
        (Code::WrongType, "b.txt:6"),
        (Code::WrongType, "b.txt:7"),
        (Code::OutOfRange, "b.txt:8"),
        (Code::OutOfRange, "b.txt:9"),
        (Code::WrongType, "b.txt:10"),
        (Code::WrongType, "b.txt:11"),
        (Code::WrongType, "b.txt:12"),
        (Code::WrongType, "b.txt:13"),
        (Code::WrongType, "b.txt:14"),
        (Code::WrongType, "b.txt:15"),
    ];
    assert_eq!(found(read_loops("b.txt", text)), faults(&expected));
}

#[test]
fn a_decimal_comma_is_never_read_as_another_point() {
    for line in ["1,5 2,5 3,5", "0,5 1 2", "1,5;2,5;3,5", "1,5\t2,5\t0", "1,5", "1,5,2,5,3,5"] {
        let faults = read_loops("b.txt", line.as_bytes()).unwrap_err();
        assert_eq!(faults.len(), 1, "{line}");
        assert!(faults[0].message.contains("decimals are written with a point"), "{}", faults[0].message);
    }
    for line in ["1, 2", "1 2", "x, y, z"] {
        let faults = read_loops("b.txt", line.as_bytes()).unwrap_err();
        assert!(!faults[0].message.contains("decimals"), "{}", faults[0].message);
    }
}

#[test]
fn what_is_no_plain_text_is_said_once() {
    let utf16: Vec<u8> = "\u{feff}0 0 0\n1 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let drawing = b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n".to_vec();
    for bytes in [utf16, drawing, super::super::dxf::BINARY_SENTINEL.to_vec()] {
        assert_eq!(found(read_loops("b.txt", &bytes)), faults(&[(Code::UnreadableFile, "b.txt:1")]));
        assert_eq!(found(read_tracks("b.txt", &bytes)), faults(&[(Code::UnreadableFile, "b.txt:1")]));
    }
}

#[test]
fn a_trace_is_courses_with_numbers_and_normals() {
    let text = b"# trace\r\ntrack 7\r\n0 1 2 0 0 1\r\n3,4,5,0,1,0\r\n\r\nTRACK 2 # next\r\n1 1 1 0 0 2";
    let tracks = read_tracks("t.txt", text).unwrap();
    assert_eq!(
        tracks.iter().map(|read| (read.track.number, read.line)).collect::<Vec<_>>(),
        [(7, 2), (2, 6)]
    );
    assert_eq!(tracks[0].lines, [3, 4]);
    assert_eq!(tracks[0].track.points[1].position, [3.0, 4.0, 5.0]);
    assert_eq!(tracks[0].track.points[1].normal, [0.0, 1.0, 0.0]);
    assert_eq!(tracks[1].track.points[0].normal, [0.0, 0.0, 2.0]);
}

#[test]
fn every_fault_of_a_trace_is_named() {
    let text = b"0 0 0 0 0 1\ntrack\n1 2 3 0 0 1\ntrack x\ntrack 0\ntrack 1000001\ntrack 1 2\ntrack +3\ntrack 4294967297\n1 2 3\ntrack 5\n1 2 3 0 0 z\n";
    let expected = [
        (Code::MissingField, "t.txt:1"),
        (Code::WrongType, "t.txt:2"),
        (Code::WrongType, "t.txt:4"),
        (Code::OutOfRange, "t.txt:5"),
        (Code::OutOfRange, "t.txt:6"),
        (Code::WrongType, "t.txt:7"),
        (Code::WrongType, "t.txt:8"),
        (Code::WrongType, "t.txt:9"),
        (Code::WrongCount, "t.txt:10"),
        (Code::WrongType, "t.txt:12"),
    ];
    assert_eq!(found(read_tracks("t.txt", text)), faults(&expected));
    assert_eq!(found(read_tracks("t.txt", b"# nothing\n")), faults(&[(Code::WrongCount, "t.txt:1")]));
}

#[test]
fn of_very_many_faults_a_hundred_are_listed_and_the_rest_counted() {
    let found = read_loops("b.txt", "x\n".repeat(250).as_bytes()).unwrap_err();
    assert_eq!((found.len(), found[100].at.as_str()), (101, "b.txt:101"));
    assert!(found[100].message.starts_with("150 further faults"), "{}", found[100]);
}

#[test]
fn more_loops_or_courses_than_there_may_be_are_refused() {
    let loops = "loop\n1 1 1\n".repeat(MOST_LOOPS + 1);
    assert_eq!(found(read_loops("b.txt", loops.as_bytes())), faults(&[(Code::WrongCount, "b.txt:20001")]));
    let tracks: String = (1..=MOST_LOOPS + 1).map(|number| format!("track {number}\n")).collect();
    assert_eq!(found(read_tracks("t.txt", tracks.as_bytes())), faults(&[(Code::WrongCount, "t.txt:10001")]));
}

proptest! {
    #[test]
    fn points_come_back_to_the_last_bit(
        loops in prop::collection::vec(prop::collection::vec(prop::array::uniform3(-1e5..1e5_f64), 0..20), 1..5),
        commas in any::<bool>(),
        carriage in any::<bool>(),
    ) {
        let (between, end) = (if commas { ", " } else { " " }, if carriage { "\r\n" } else { "\n" });
        let mut text = String::new();
        for points in &loops {
            text += &format!("loop{end}");
            for [x, y, z] in points {
                text += &format!("{x}{between}{y}{between}{z}{end}");
            }
        }
        let read = read_loops("b.txt", text.as_bytes()).unwrap();
        prop_assert_eq!(read.into_iter().map(|read| read.points).collect::<Vec<_>>(), loops);
    }

    #[test]
    fn any_bytes_are_read_or_refused_at_a_line_that_is_there(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        check_places(&bytes)?;
    }

    #[test]
    fn any_text_of_the_usual_characters_is_read_or_refused(text in "[-0-9.,e \t\r\n#trackloopnif+]{0,120}") {
        check_places(text.as_bytes())?;
    }
}

fn check_places(bytes: &[u8]) -> Result<(), TestCaseError> {
    let lines = bytes.split(|byte| *byte == b'\n').count();
    for (_, at) in found(read_loops("b.txt", bytes)).into_iter().chain(found(read_tracks("b.txt", bytes))) {
        let line: usize = at.strip_prefix("b.txt:").unwrap().parse().unwrap();
        prop_assert!((1..=lines).contains(&line), "{at} of {lines}");
    }
    Ok(())
}
