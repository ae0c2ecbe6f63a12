use super::*;
use crate::planning::geometry::frame::Frame;
use crate::planning::program::robot_events::RobotEvent;

const FRAMES: &str = "$TOOL={X 0,Y 0,Z 300,A 0,B 0,C 0}\n$BASE={X 1500,Y 0,Z 800,A 90,B 0,C 0}\n";

fn source(name: &str, text: &str) -> ProgramFile {
    ProgramFile { name: name.to_owned(), dialect: "krl", text: text.to_owned() }
}

/// What the files do; the first is the main one.
fn run(files: &[(&str, &str)]) -> Result<Vec<RobotExecuted>, Vec<Finding>> {
    let files: Vec<_> = files.iter().map(|(name, text)| source(name, text)).collect();
    execute(&files, &files[0].name)
}

/// What a body does, without frames and end.
fn body(text: &str) -> Vec<RobotEvent> {
    let all = run(&[("p.src", &format!("DEF p()\n{FRAMES}{text}\nEND\n"))]).unwrap();
    let events: Vec<_> = all.into_iter().map(|executed| executed.event).collect();
    events[2..events.len() - 1].to_vec()
}

/// The one fault of a body whose first line is line 1, as `LINE:COLUMN` and message.
fn refused(text: &str) -> (String, String) {
    let program = format!("DEF p()\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n{text}\nEND\n");
    let found = run(&[("p.src", &program)]).unwrap_err();
    assert_eq!(found.len(), 1, "{text}: {found:?}");
    assert_eq!(found[0].code, Code::UnreadableProgram, "{text}");
    let (line, column) = found[0].at.strip_prefix("p.src:").unwrap().split_once(':').unwrap();
    let line: usize = line.parse().unwrap();
    (format!("{}:{column}", line - 3), found[0].message.clone())
}

fn frame(x_mm: f64, y_mm: f64, z_mm: f64, a_deg: f64, b_deg: f64, c_deg: f64) -> Frame {
    Frame { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg }
}

fn line(frame: Frame) -> RobotEvent {
    RobotEvent::Line { frame, blend: false }
}

#[test]
fn a_point_is_read_however_it_is_written() {
    let expected = [line(frame(1.0, -2.5, 3.0, 40.0, 0.5, -60.0))];
    let texts = [
        "LIN {X 1,Y -2.5,Z 3,A 40,B .5,C -60}",
        "lin { x 1.0 , y -2.5 , z 3. , a 4E1 , b 5e-1 , c -60 } ; there",
        "\tSLIN {E6POS: C -60.0,B 0.5,A 40.0,Z 3.0,Y -2.5,X 1.0,E1 0.0,E2 0,S 'B010',T 'b100011'}",
        "Lin {FRAME: X +1,Y -2.5,Z 3,A 40,B 0.5,C -60} ",
        "LIN {POS: X 1,Y -2.5,Z 3,A 40,B 0.5,C -60,S 2,T 35}",
    ];
    for text in texts {
        assert_eq!(body(text), expected, "{text}");
    }
}

#[test]
fn every_suffix_that_rounds_an_end_off_does() {
    let blended = [RobotEvent::Line { frame: frame(1.0, 2.0, 3.0, 0.0, 0.0, 0.0), blend: true }];
    for suffix in ["C_DIS", "c_vel", "C_ORI", "C_DIS C_DIS"] {
        assert_eq!(body(&format!("LIN {{X 1,Y 2,Z 3,A 0,B 0,C 0}} {suffix}")), blended, "{suffix}");
    }
    assert_eq!(body("SLIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_SPL"), blended);
    let joint = [RobotEvent::PoseTo { frame: frame(1.0, 2.0, 3.0, 0.0, 0.0, 0.0), blend: true }];
    for text in ["PTP {X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 2} C_PTP C_DIS", "SPTP {X 1,Y 2,Z 3,A 0,B 0,C 0} C_SPL"]
    {
        assert_eq!(body(text), joint, "{text}");
    }
}

#[test]
fn what_a_point_leaves_out_stays_as_it_was() {
    let whole = "LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n";
    assert_eq!(body(&format!("{whole}LIN {{Y 9}}"))[1], line(frame(1.0, 9.0, 3.0, 4.0, 5.0, 6.0)));
    let (at, message) = refused("LIN {X 1,Z 3,A 4,B 5,C 6}");
    assert_eq!(at, "1:5");
    assert!(message.starts_with("Y is not given"), "{message}");
    // Joint angles and other frames move the tool to where the text does not say.
    for between in
        ["PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}", "$BASE={X 5}", "$TOOL={Z 5}", "BAS(#BASE,0)\n$BASE={X 1}"]
    {
        let (at, _) = refused(&format!("{whole}{between}\nLIN {{Y 9}}"));
        assert!(at.ends_with(":5"), "{between}: {at}");
    }
    assert_eq!(body(&format!("{whole}{FRAMES}LIN {{Y 9}}")).len(), 4, "the same frames once more");
}

#[test]
fn joints_are_joints() {
    let to = |joints| RobotEvent::JointsTo { joints };
    let events = body("PTP {A1 0,A2 -90.0,A3 90,A4 0,A5 5,A6 0}\nptp {axis: a6 7}\nPTP_REL {A1 -3,A6 1}");
    let expected = [
        to([0.0, -90.0, 90.0, 0.0, 5.0, 0.0]),
        to([0.0, -90.0, 90.0, 0.0, 5.0, 7.0]),
        to([-3.0, -90.0, 90.0, 0.0, 5.0, 8.0]),
    ];
    assert_eq!(events, expected);
}

#[test]
fn relative_motions_shift_along_the_base_or_the_tool() {
    let start = "LIN {X 1,Y 2,Z 3,A 90,B 0,C 0}\n";
    assert_eq!(
        body(&format!("{start}LIN_REL {{Z -2,X 10}}"))[1],
        line(frame(11.0, 2.0, 1.0, 90.0, 0.0, 0.0))
    );
    assert_eq!(body(&format!("{start}LIN_REL {{X 1}} C_DIS #BASE")).len(), 2);
    let RobotEvent::Line { frame, .. } = &body(&format!("{start}LIN_REL {{X 10}} #TOOL"))[1] else {
        panic!()
    };
    assert!((frame.x_mm - 1.0).abs() < 1e-12 && (frame.y_mm - 12.0).abs() < 1e-12, "{frame:?}");
    assert_eq!(refused("LIN_REL {X 1}").0, "1:9");
    assert_eq!(refused(&format!("{start}LIN_REL {{A 1}}")).0, "2:9");
    assert_eq!(refused(&format!("{start}LIN_REL P")).0, "2:9");
}

#[test]
fn speeds_and_what_else_holds_from_here_on() {
    let events = body(
        "$VEL.CP=0.2\n$VEL={CP 0.1,ORI1 90,ORI2 45.0}\n$VEL.ORI2=200\n$APO.CDIS=2\n$APO={CPTP 10,CDIS 3}\n\
         $OUT[7]=true\nWAIT SEC 0.5\nHALT\nBAS(#VEL_CP,0.3)\n$ADVANCE=3\n$ACC.CP=$ACC_MA.CP\n$VEL_AXIS[1]=20\n\
         $IPO_MODE=#BASE\n$ORI_TYPE = #VAR\nCONTINUE\nBAS (#ACC_PTP,20 )",
    );
    let expected = [
        RobotEvent::PathSpeed { mm_s: 200.0 },
        RobotEvent::PathSpeed { mm_s: 100.0 },
        RobotEvent::TurnSpeed { deg_s: 90.0 },
        RobotEvent::TurnSpeed { deg_s: 45.0 },
        RobotEvent::TurnSpeed { deg_s: 90.0 },
        RobotEvent::BlendDistance { mm: 2.0 },
        RobotEvent::BlendDistance { mm: 3.0 },
        RobotEvent::Output { number: 7, on: true },
        RobotEvent::Dwell { seconds: 0.5 },
        RobotEvent::Halt,
        RobotEvent::PathSpeed { mm_s: 300.0 },
    ];
    assert_eq!(events, expected);
}

#[test]
fn a_trigger_acts_as_the_next_motion_begins() {
    let all = run(&[(
        "p.src",
        &format!("DEF p()\n{FRAMES}TRIGGER WHEN DISTANCE=0 DELAY = 0 DO $OUT[3]=TRUE\nWAIT SEC 1\nLIN {{X 0,Y 0,Z 0,A 0,B 0,C 0}}\nEND"),
    )])
    .unwrap();
    let order: Vec<_> = all.iter().skip(2).map(|executed| executed.line).collect();
    assert_eq!(order, [5, 4, 6, 7]);
    assert_eq!(all[3].event, RobotEvent::Output { number: 3, on: true });
    // The motion to where the arm stands is none.
    let (at, message) = refused("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=TRUE\nPTP $POS_ACT");
    assert_eq!(at, "1:36");
    assert!(message.contains("no motion follows"), "{message}");
}

#[test]
fn points_of_data_lists_are_found() {
    let main =
        "DEF p()\n$BASE=BASE_DATA[3]\n$TOOL=t1\nPTP HOME\nLIN XP1 C_DIS\nLIN other\nXP1.Z=-1\nLIN XP1\nEND";
    let own = "&ACCESS RVP\nDEFDAT P PUBLIC\nEXT BAS (BAS_COMMAND :IN,REAL :IN )\n;FOLD points\n\
               DECL E6POS XP1={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0,S 6,T 27,E1 0.0}\nFRAME t1={X 0,Y 0,Z 1,A 0,B 0,C 0}\n\
               DECL E6AXIS HOME={A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nDECL BASIS_SUGG_T LAST={POINT1[] \"P1  \"}\n\
               DECL CHAR NOTE[20]\nNOTE[]=\"a;b\" ; said\n;ENDFOLD\nENDDAT";
    // What the control's own list declares, all see; of another list, only what is global.
    let config =
        "DEFDAT $CONFIG PUBLIC\nDECL FRAME BASE_DATA[32]\nBASE_DATA[3]={X 0,Y 0,Z 5,A 0,B 0,C 0}\nENDDAT";
    let others = "DEFDAT q PUBLIC\nDECL GLOBAL POS other={X 7,Y 7,Z 7,A 0,B 0,C 0}\nENDDAT";
    let with =
        |others: &str| run(&[("p.src", main), ("P.DAT", own), ("$config.dat", config), ("q.dat", others)]);
    let all = with(others).unwrap();
    let events: Vec<_> = all.into_iter().map(|executed| executed.event).collect();
    assert_eq!(events[0], RobotEvent::Base { frame: frame(0.0, 0.0, 5.0, 0.0, 0.0, 0.0) });
    assert_eq!(events[1], RobotEvent::Tool { frame: frame(0.0, 0.0, 1.0, 0.0, 0.0, 0.0) });
    assert_eq!(events[4], line(frame(7.0, 7.0, 7.0, 0.0, 0.0, 0.0)));
    assert_eq!(events[5], line(frame(1.0, 2.0, -1.0, 0.0, 0.0, 0.0)));
    let found = with(&others.replace("GLOBAL ", "")).unwrap_err();
    assert_eq!(found[0].at, "p.src:6:5");
}

#[test]
fn the_forms_of_the_teach_pendant_are_followed() {
    let main = ";FOLD LIN P8 CONT Vel=2 m/s CPDAT17 Tool[1] Base[2];%{PE}%R 8.3.48\nDEF p()\nBAS (#INITMOV,0 )\n\
                $BWDSTART=FALSE\nLDAT_ACT=LCPDAT17\nFDAT_ACT=FP8\nBAS(#CP_PARAMS,2)\nLIN XP8 C_DIS C_DIS\nEND";
    let data = "DEFDAT p\nDECL E6POS XP8={X 1,Y 2,Z 3,A 0,B 0,C 0}\n\
                DECL FDAT FP8={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] \" \"}\n\
                DECL LDAT LCPDAT17={VEL 2.0,ACC 100.0,APO_DIST 4.0,APO_FAC 50.0,ORI_TYP #VAR}\n\
                TOOL_DATA[1]={X 0,Y 0,Z 9,A 0,B 0,C 0}\nBASE_DATA[2]={X 8,Y 0,Z 0,A 0,B 0,C 0}\nENDDAT\n";
    let all = run(&[("p.src", main), ("p.dat", data)]).unwrap();
    let events: Vec<_> = all.into_iter().map(|executed| executed.event).collect();
    let expected = [
        RobotEvent::Tool { frame: frame(0.0, 0.0, 9.0, 0.0, 0.0, 0.0) },
        RobotEvent::Base { frame: frame(8.0, 0.0, 0.0, 0.0, 0.0, 0.0) },
        RobotEvent::PathSpeed { mm_s: 2000.0 },
        RobotEvent::BlendDistance { mm: 4.0 },
        RobotEvent::Line { frame: frame(1.0, 2.0, 3.0, 0.0, 0.0, 0.0), blend: true },
        RobotEvent::End,
    ];
    assert_eq!(events, expected);
    for (from, to) in [("#BASE", "#TCP"), ("ORI_TYP #VAR", "ORI_TYP #CONSTANT"), ("APO_DIST 4.0,", "")] {
        assert!(run(&[("p.src", main), ("p.dat", &data.replace(from, to))]).is_err(), "{from}");
    }
}

#[test]
fn sub_programs_are_called_and_layers_left_out() {
    let main = "DEF p()\n$VEL.CP=1\nsub()\nlocal()\nEND\nDEF local()\n$VEL.CP=3\nRETURN\n$VEL.CP=9\nEND\n";
    let sub = "DEF SUB( )\nIF p_first<=1 THEN\n$VEL.CP=2\nELSE\n$VEL.CP=4\nENDIF\nIF (2 <> 2) THEN\nHALT\nENDIF\nEND";
    let data = "DEFDAT p PUBLIC\nDECL GLOBAL INT p_first=1\nENDDAT";
    let speeds = |data: &str| -> Vec<(usize, f64)> {
        let all = run(&[("p.src", main), ("sub.src", sub), ("p.dat", data)]).unwrap();
        assert_eq!(all.last().map(|executed| &executed.event), Some(&RobotEvent::End));
        let speed = |executed: &RobotExecuted| match executed.event {
            RobotEvent::PathSpeed { mm_s } => Some((executed.file, mm_s)),
            _ => None,
        };
        all.iter().filter_map(speed).collect()
    };
    assert_eq!(speeds(data), [(0, 1000.0), (1, 2000.0), (0, 3000.0)]);
    assert_eq!(speeds(&data.replace("=1", "=2")), [(0, 1000.0), (1, 4000.0), (0, 3000.0)]);
    let found = run(&[("p.src", main), ("sub.src", sub)]).unwrap_err();
    assert_eq!(found[0].at, "sub.src:2:4");
}

#[test]
fn calls_have_an_end() {
    let itself = run(&[("p.src", "DEF p()\np()\nEND")]).unwrap_err();
    assert_eq!((itself[0].at.as_str(), itself[0].code), ("p.src:2:1", Code::UnreadableProgram));
    let chain: Vec<_> =
        (0..20).map(|n| (format!("p{n}.src"), format!("DEF p{n}()\np{}()\nEND", n + 1))).collect();
    let chain: Vec<_> = chain.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let deep = run(&chain).unwrap_err();
    assert!(deep[0].message.contains("16 deep"), "{deep:?}");
    // Ten programs, each of which calls the next ten times over.
    let calls = |n: usize| format!("p{n}()\n").repeat(10);
    let bomb: Vec<_> =
        (0..10).map(|n| (format!("p{n}.src"), format!("DEF p{n}()\n{}END", calls(n + 1)))).collect();
    let mut bomb: Vec<_> = bomb.iter().map(|(name, text)| source(name, text)).collect();
    bomb.push(source("p10.src", "DEF p10()\nEND"));
    let bomb = run::run(&Program::of(&bomb).unwrap(), "p0.src", 10_000).unwrap_err();
    assert!(bomb.message.contains("more than 10000 things"), "{bomb:?}");
}

#[test]
fn lines_end_as_they_like() {
    for end in ["\n", "\r\n"] {
        for last in ["", end] {
            let text =
                ["&ACCESS RVP", "DEF p( )", "", "  ; only said \u{e4}", "$VEL.CP=1", "END"].join(end) + last;
            let all = run(&[("p.src", &text)]).unwrap();
            assert_eq!(all.iter().map(|executed| executed.line).collect::<Vec<_>>(), [5, 6]);
        }
    }
    assert_eq!(run(&[("p.src", "\u{feff}DEF p()\nEND")]).unwrap().len(), 1);
}

/// Bodies that are refused: their place, and a part of what is said.
const REFUSED: &[(&str, &str, &str)] = &[
    ("CIRC {X 1},{X 2}", "1:1", "arc"),
    ("  SCIRC XP1, XP2", "1:3", "arc"),
    ("SPL XP1", "1:1", "spline"),
    ("SPLINE", "1:1", "spline"),
    ("ASYPTP {E1 5}", "1:1", "no place"),
    ("BRAKE", "1:1", "no place"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_FOO", "1:31", "C_FOO is no suffix"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_PTP", "1:31", "no suffix of LIN"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_DIS C_DIS C_DIS", "1:43", "at most two"),
    ("SLIN {X 1,Y 2,Z 3,A 0,B 0,C 0} WITH $VEL.CP=1", "1:32", "WITH"),
    ("SLIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_SPL WITH $VEL.CP=1", "1:38", "WITH"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} #BASE", "1:32", "relative"),
    ("LIN {X 1,Y 2,Z 3,A 0,B 0,C 0}:{X 1}", "1:30", "put together"),
    ("LIN P:Q", "1:6", "put together"),
    ("LIN P", "1:5", "does not stand"),
    ("LIN {X a,Y 2,Z 3,A 0,B 0,C 0}", "1:8", "written out"),
    ("LIN {X 1+1,Y 2,Z 3,A 0,B 0,C 0}", "1:9", "\"}\" belongs here"),
    ("LIN {X 1,X 2}", "1:10", "X stands twice"),
    ("LIN {X 1,Q 2}", "1:10", "a point has no Q"),
    ("LIN {X TRUE}", "1:8", "needs a number"),
    ("LIN {X 1e7}", "1:8", "a robot can have"),
    ("LIN {X 1E999}", "1:8", "too large"),
    ("LIN {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}", "1:5", "not to joint angles"),
    ("PTP {A1 1,A2 2,A3 3,A4 4,A5 5,A6 6} C_PTP", "1:5", "rounded off"),
    ("PTP {A1 1,X 2}", "1:6", "not both"),
    ("PTP {A1 1}", "1:5", "A2 is not given"),
    ("PTP {E1 0}", "1:6", "neither"),
    ("PTP {X 1,Y 2,Z 3,A 0,B 0,C 0,E1 5}", "1:33", "external axis"),
    ("PTP {AXIS: X 1}", "1:12", "components of a AXIS"),
    ("PTP {FRAME X 1}", "1:12", "a value is written out"),
    ("LIN {X 1,Y 2", "1:13", "\"}\" belongs here"),
    ("LIN {}", "1:6", "a name belongs here"),
    ("LIN", "1:4", "a point belongs here"),
    ("LIN {X 1.0.0}", "1:8", "runs into"),
    ("LIN {X 1Y 2}", "1:8", "runs into"),
    ("LIN {X 1,\u{e4} 2}", "1:10", "no meaning"),
    ("LIN_REL {X 1} #WORLD", "1:16", "neither #BASE nor #TOOL"),
    ("FOR I=1 TO 3", "1:1", "FOR is refused"),
    ("LOOP", "1:1", "LOOP is refused"),
    ("GOTO x", "1:1", "GOTO is refused"),
    ("SWITCH i", "1:1", "SWITCH is refused"),
    ("SIGNAL s $OUT[1]", "1:1", "does not follow"),
    ("DECL INT i", "1:1", "before the first instruction"),
    ("INTERRUPT DECL 4 WHEN $IN[1]==TRUE DO stop()", "1:11", "not known"),
    ("GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO other ( )", "1:18", "not known"),
    ("TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[1]=TRUE", "1:23", "DISTANCE is 0"),
    ("TRIGGER WHEN DISTANCE=0 DELAY=-20 DO $OUT[1]=TRUE", "1:31", "DELAY is 0"),
    ("TRIGGER WHEN PATH=0 DELAY=0 DO $OUT[1]=TRUE", "1:14", "DISTANCE belongs here"),
    ("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE PRIO=-1", "1:49", "not computed"),
    ("TRIGGER WHEN DISTANCE=0 DELAY=0 DO x=TRUE", "1:36", "more than set an output"),
    ("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=2", "1:44", "TRUE or FALSE"),
    ("$OUT[0]=TRUE", "1:1", "numbered from 1"),
    ("$OUT[i]=TRUE", "1:6", "written out"),
    ("$OUT[1]=NOT $IN[1]", "1:13", "not computed"),
    ("$ANOUT[1]=0.5", "1:1", "not known"),
    ("$OV_PRO=50", "1:1", "not known"),
    ("$IPO_MODE=#TCP", "1:11", "only #BASE"),
    ("$ORI_TYPE=#CONSTANT", "1:11", "only #VAR"),
    ("$VEL.CP=0", "1:9", "no speed"),
    ("$VEL.CP=fast", "1:9", "does not stand"),
    ("$VEL={CP 1,FOO 2}", "1:6", "FOO"),
    ("$VEL.CP=0.1*2", "1:12", "not computed"),
    ("$APO.CDIS=-1", "1:11", "no distance"),
    ("$BASE=5", "1:7", "a frame belongs here"),
    ("WAIT FOR $IN[1]", "1:6", "does not stand in its text"),
    ("WAIT SEC -1", "1:1", "not negative"),
    ("x=1", "1:1", "not known"),
    ("x", "1:1", "begins no statement"),
    ("what()", "1:1", "what WHAT does"),
    ("p(1)", "1:1", "called with values"),
    ("IF TRUE THEN\nENDIF", "1:9", "comparison"),
    ("IF $IN[1]==1 THEN\nENDIF", "1:4", "does not stand"),
    ("IF 1==1\nENDIF", "1:8", "THEN belongs here"),
    ("IF 1==1 THEN", "1:1", "ENDIF is missing"),
    ("ELSE", "1:1", "no IF"),
    ("ENDIF", "1:1", "no IF"),
    ("IF 1==1 THEN\nELSE\nELSE\nENDIF", "3:1", "has an ELSE"),
    ("BAS (#EX_BASE,1)", "1:6", "not known"),
    ("BAS (#CP_PARAMS,1)", "1:6", "FDAT_ACT"),
    ("this_name_has_twenty_five=1", "1:1", "25 characters"),
    ("\"text", "1:1", "not closed"),
    ("'Q1'", "1:1", "'B010'"),
    ("\\", "1:1", "no meaning"),
    ("HALT now", "1:6", "should end"),
    ("&ACCESS RVP", "1:1", "head of a file"),
    ("DEF q()", "1:1", "END is missing"),
    ("ENDDAT", "1:1", "ends nothing"),
    ("A 1", "1:1", "begins no statement"),
    ("a.b.c=1", "1:4", "component of a component"),
];

#[test]
fn refuses_each_body_at_its_place() {
    for (text, place, message) in REFUSED {
        let (at, said) = refused(text);
        assert_eq!(at, *place, "{text}: {said}");
        assert!(said.contains(message), "{text}: {said}");
    }
}

#[test]
fn a_frame_that_stands_in_the_control_is_refused_where_something_goes() {
    let program = |set: &str| format!("DEF p()\n{set}\nWAIT SEC 1\nLIN {{X 1,Y 2,Z 3,A 0,B 0,C 0}}\nEND");
    let cases = [
        ("$TOOL=$NULLFRAME\n$BASE=BASE_DATA[1]", "BASE_DATA[1]"),
        ("$BASE=$NULLFRAME\n$TOOL=TOOL_DATA[7]", "TOOL_DATA[7]"),
        ("$BASE=$NULLFRAME\nBAS (#TOOL,2)", "TOOL_DATA[2]"),
        ("$TOOL=$NULLFRAME\n", "$BASE is not set"),
        ("$TOOL=$NULLFRAME\n$BASE=$WORLD\nBAS(#INITMOV,0)", "INITMOV"),
    ];
    for (set, why) in cases {
        let found = run(&[("p.src", &program(set))]).unwrap_err();
        assert_eq!(found.len(), 1);
        assert!(found[0].at.ends_with(":1") && found[0].message.contains(why), "{set}: {found:?}");
    }
    // Where nothing depends on it, it is none of our business.
    assert!(run(&[("p.src", "DEF p()\n$BASE=BASE_DATA[1]\nEND")]).is_ok());
}

#[test]
fn a_file_is_whole_and_has_its_name() {
    let cases: &[(&str, &str, &str, Code)] = &[
        ("p.src", "", "p.src:1:1", Code::NoProgramEnd),
        ("p.src", "; nothing\n", "p.src:1:1", Code::NoProgramEnd),
        ("p.src", "DEF p()\n$VEL.CP=1\n", "p.src:2:1", Code::NoProgramEnd),
        ("p.src", "DEF p(\nHALT\nEND\n", "p.src:1:7", Code::UnreadableProgram),
        ("p.dat", "DEFDAT\nINT i=1\nENDDAT\n", "p.dat:1:7", Code::UnreadableProgram),
        ("p.src", "DEF q()\nEND\n", "p.src:1:1", Code::UnreadableProgram),
        ("p.src", "DEF p()\nEND\nHALT\n", "p.src:3:1", Code::UnreadableProgram),
        ("p.src", "HALT\nDEF p()\nEND\n", "p.src:1:1", Code::UnreadableProgram),
        ("p.src", "DEF p()\nDECL INT i=1\nEND\n", "p.src:2:1", Code::UnreadableProgram),
        ("p.dat", "DEFDAT p\nINT i=1\n", "p.dat:2:1", Code::NoProgramEnd),
        ("p.dat", "DEFDAT p\nHALT\nENDDAT\n", "p.dat:2:1", Code::UnreadableProgram),
        ("p.dat", "DEFDAT q\nENDDAT\n", "p.dat:1:1", Code::UnreadableProgram),
        ("p.dat", "DEFDAT p\nENDDAT\n", "p.dat:1:1", Code::UnreadableProgram),
    ];
    for (name, text, at, code) in cases {
        let found = run(&[(name, text)]).unwrap_err();
        assert_eq!((found[0].at.as_str(), found[0].code), (*at, *code), "{text:?}");
    }
    assert_eq!(execute(&[], "p.src").unwrap_err()[0].at, "p.src:1:1");
}

#[test]
fn every_refused_line_is_named_up_to_a_bound() {
    let found = run(&[("p.src", "DEF p()\nCIRC\nHALT\nSPL\nEND")]).unwrap_err();
    assert_eq!(found.iter().map(|fault| fault.at.as_str()).collect::<Vec<_>>(), ["p.src:2:1", "p.src:4:1"]);
    let hopeless = run(&[("p.src", &"hello\n".repeat(100_000))]).unwrap_err();
    assert_eq!(hopeless.len(), MOST_FAULTS + 1);
    assert!(hopeless[MOST_FAULTS].message.contains("not read"));
    let long = format!("DEF p()\n;{}\nEND", "x".repeat(4096));
    assert_eq!(run(&[("p.src", &long)]).unwrap_err()[0].at, "p.src:2:1");
}

#[test]
fn the_statement_of_a_line_is_where_its_span_says() {
    let lines = statements("  LIN {X 1} ; \u{e4}\r\n\n&REL 1\nPTP ;x\n\tCIRC a\r\n");
    let spans: Vec<_> = lines.iter().map(|line| &line.text[line.span.clone()]).collect();
    assert_eq!(spans, ["LIN {X 1}", "", "&REL 1", "PTP", "CIRC a"]);
    assert_eq!(lines.iter().map(|line| line.number).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    assert_eq!(
        lines.iter().map(statement::Line::is_motion).collect::<Vec<_>>(),
        [true, false, false, true, true]
    );
    assert_eq!(lines[3].statement.as_ref().unwrap_err().column, 4);
    assert_eq!(lines[4].statement.as_ref().unwrap_err().column, 2);
}

proptest::proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..300)) {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let _ = run(&[("p.src", &text), ("p.dat", &text)]);
        let _ = run(&[("p.src", &format!("DEF p()\n{text}\nEND"))]);
    }

    #[test]
    fn any_mix_of_words_is_read_or_refused(
        words in "((LIN|PTP|SLIN|LIN_REL|IF|ELSE|ENDIF|THEN|DECL|INT|\\$VEL|\\$BASE|BAS|TRIGGER|WAIT|SEC|#|\\{|\\}|\\(|\\)|\\[|\\]|=|<=|:|,|\\.|X|A1|-|1|2\\.5|'B1'|\"t\"|;|\n| ) ?){0,60}"
    ) {
        let _ = run(&[("p.src", &format!("DEF p()\n{words}\nEND"))]);
        let _ = run(&[("p.src", "DEF p()\nLIN P\nEND"), ("p.dat", &format!("DEFDAT p\n{words}\nENDDAT"))]);
    }
}
