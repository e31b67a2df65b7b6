//! URDFs with the traits of public ones: turned frames, fixed joints, branches, joints without limits, arms without a
//! spacecraft; and what is refused.

use dem_model::nalgebra::{Matrix3, Vector2, Vector3};
use dem_model::{FreeFloatingManipulator, JointMotion, SerialState, SphericalBaseManipulator};
use uarm_urdf::{Arm, Base, Chain, Names, Selection, Spacecraft, UrdfError, write_mjcf, write_urdf};

const INERTIA: &str = r#"<inertia ixx="0.3" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.1"/>"#;

/// A bus with a fixed mount, two joints of which the first is turned by a quarter about z, a side branch, and a tool.
fn arm() -> String {
    format!(
        r#"<?xml version="1.0"?>
<robot name="test arm">
  <material name="grey"/>
  <link name="bus"><inertial><origin xyz="0.5 0 0"/><mass value="80"/>
    <inertia ixx="9" iyy="8" izz="7"/></inertial><visual><geometry><mesh filename="bus.stl"/></geometry></visual></link>
  <link name="mount"><inertial><origin xyz="0 0 1"/><mass value="20"/>{INERTIA}</inertial></link>
  <joint name="fixed" type="fixed"><parent link="bus"/><child link="mount"/><origin xyz="1 0 0"/></joint>
  <link name="upper"><inertial><origin xyz="1 0 0"/><mass value="4"/>{INERTIA}</inertial></link>
  <joint name="shoulder" type="revolute"><parent link="mount"/><child link="upper"/>
    <origin xyz="0 0 0.5" rpy="0 0 1.5707963267948966"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="0.5"/></joint>
  <link name="camera"><inertial><origin xyz="0 0 0"/><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="pan" type="continuous"><parent link="upper"/><child link="camera"/><origin xyz="0 0 1"/></joint>
  <link name="slider"><inertial><origin xyz="0 0 0.25"/><mass value="2"/>{INERTIA}</inertial></link>
  <joint name="extend" type="prismatic"><parent link="upper"/><child link="slider"/><origin xyz="2 0 0"/>
    <axis xyz="0 0 2"/></joint>
  <link name="tool"/>
  <joint name="flange" type="fixed"><parent link="slider"/><child link="tool"/><origin xyz="0 0 1"/></joint>
</robot>"#
    )
}

fn with_tip(tip: &str) -> Selection {
    Selection { tip: Some(tip.to_owned()), ..Selection::default() }
}

fn close(found: Vector3<f64>, expected: [f64; 3]) {
    assert!((found - Vector3::from(expected)).amax() < 1e-12, "{found} instead of {expected:?}");
}

#[test]
fn bodies_are_joined_and_turned_into_base_axes() {
    let arm = Arm::parse(&arm(), &with_tip("tool")).unwrap();
    assert_eq!(arm.spacecraft.merged, ["mount"]);
    assert_eq!(arm.locked, ["pan"]);
    // (80 · 0.5 + 20 · 1) / 100 along x, 20 · 1 / 100 along z.
    assert_eq!(arm.spacecraft.body.mass, 100.0);
    close(arm.spacecraft.body.centre, [0.6, 0.0, 0.2]);
    // Steiner: I_zz = 7 + 80 · 0.1² + 0.1 + 20 · 0.4²; I_xz = −Σ m x z about the centre.
    let inertia = arm.spacecraft.body.inertia;
    assert!((inertia.m33 - (7.0 + 0.8 + 0.1 + 3.2)).abs() < 1e-12, "{inertia}");
    let product: f64 = -(80.0 * (-0.1) * (-0.2) + 20.0 * 0.4 * 0.8);
    assert!((inertia.m13 - product).abs() < 1e-12, "{inertia}");

    // A quarter turn about z takes x to y: the shoulder turns about y, and the upper arm lies along y.
    let [shoulder, extend] = arm.joints.as_slice() else { panic!("{:?}", arm.joints) };
    assert_eq!((shoulder.motion, extend.motion), (JointMotion::Revolute, JointMotion::Prismatic));
    close(shoulder.axis, [0.0, 1.0, 0.0]);
    close(shoulder.place, [1.0, 0.0, 0.5]);
    close(extend.place, [1.0, 2.0, 0.5]);
    // The upper arm with its camera: (4 · [1, 1, 0.5] + 1 · [1, 0, 1.5]) / 5.
    close(arm.links[0].body.centre, [1.0, 0.8, 0.7]);
    assert_eq!(arm.links[0].merged, ["camera"]);
    close(arm.links[1].body.centre, [1.0, 2.0, 0.75]);
    // I_xx and I_yy have changed places.
    assert!((arm.links[1].body.inertia.m11 - 0.2).abs() < 1e-12, "{}", arm.links[1].body.inertia);
    close(arm.tip, [1.0, 2.0, 1.5]);

    let limits = shoulder.limits.unwrap();
    assert_eq!((limits.lower, limits.upper, limits.effort, limits.velocity), (Some(-1.0), Some(2.0), 30.0, 0.5));
    assert_eq!(extend.limits, None);

    let (manipulator, joints) = arm.space_manipulator::<2>().unwrap();
    close(manipulator.spacecraft().centre_of_mass_to_joint, [0.4, 0.0, 0.3]);
    close(manipulator.links()[0].joint_to_centre_of_mass, [0.0, 0.8, 0.2]);
    close(manipulator.links()[1].centre_of_mass_to_joint, [0.0, 0.0, 0.75]);
    assert_eq!(joints[1].axis().into_inner(), Vector3::z());
}

#[test]
fn what_is_written_reads_back_with_the_same_dynamics() {
    let first = Arm::parse(&arm(), &with_tip("tool")).unwrap();
    let (manipulator, joints) = first.space_manipulator::<2>().unwrap();
    let names = Names::numbered("again", "spacecraft", 2);
    let text = write_urdf(&Chain::space_manipulator(&names, &manipulator, &joints));
    let second = Arm::parse(&text, &Selection::default()).unwrap();
    let again = second.space_manipulator::<2>().unwrap();
    let state = SerialState {
        position: Vector2::new(0.7, 0.2),
        velocity: Vector2::new(-0.4, 0.3),
        base_velocity: dem_model::nalgebra::Vector6::new(0.1, -0.2, 0.3, 0.4, 0.5, -0.6),
    };
    let before = FreeFloatingManipulator::free_floating(&manipulator, joints);
    let after = FreeFloatingManipulator::free_floating(&again.0, again.1);
    assert!((before.dynamics(&state).mass_bb - after.dynamics(&state).mass_bb).amax() < 1e-12);
    assert!((before.dynamics(&state).coriolis_mb - after.dynamics(&state).coriolis_mb).amax() < 1e-12);
    assert!((before.tool(&state.position).place - after.tool(&state.position).place).amax() < 1e-12);
}

#[test]
fn the_dem_is_written_with_its_passive_joint() {
    let text = arm().replace("prismatic", "continuous");
    let arm = Arm::parse(&text, &with_tip("tool")).unwrap();
    let (manipulator, joints) = arm.space_manipulator::<2>().unwrap();
    let dem = manipulator.dynamically_equivalent();
    let names = Names::numbered("dem", "base", 2);
    let chain = Chain::equivalent(&names, Base::Spherical, 100.0, &dem, &joints).unwrap();
    let mjcf = write_mjcf(&chain);
    for expected in [
        r#"<joint name="base" type="ball"/>"#,
        r#"<option gravity="0 0 0" integrator="RK4"/>"#,
        r#"<joint name="joint_2" type="hinge""#,
        r#"<motor joint="joint_3"/>"#,
    ] {
        assert!(mjcf.contains(expected), "no {expected} in\n{mjcf}");
    }
    // The written DEM is an arm of its own whose parameters are the map's.
    let read = Arm::parse(&write_urdf(&chain), &Selection::default()).unwrap();
    assert_eq!(read.links[0].body.mass, dem.links()[0].mass);
    close(read.joints[1].place - read.joints[0].place, dem.links()[0].length.into());
    let moves = SphericalBaseManipulator::new(&dem, joints).unwrap();
    close(moves.tool(&Vector2::zeros()).place, read.tip.into());

    let sliding = Arm::parse(&self::arm(), &with_tip("tool")).unwrap().space_manipulator::<2>().unwrap();
    assert_eq!(Chain::equivalent(&names, Base::Spherical, 1.0, &sliding.0.dynamically_equivalent(), &sliding.1), None);
}

#[test]
fn an_arm_without_a_spacecraft_gets_one() {
    let bare = arm()
        .replace(r#"<mass value="80"/>"#, r#"<mass value="0"/>"#)
        .replace("<mass value=\"20\"/>", "<mass value=\"0\"/>");
    let error = Arm::parse(&bare, &with_tip("tool")).unwrap_err();
    assert_eq!(error, UrdfError::NoSpacecraft { link: "bus".to_owned(), found: 0.0 });
    let spacecraft = Spacecraft::new(50.0, Matrix3::identity());
    assert!(spacecraft.is_some());
    for (mass, inertia) in [
        (0.0, Matrix3::identity()),
        (f64::INFINITY, Matrix3::identity()),
        (50.0, -Matrix3::identity()),
        (50.0, Matrix3::new(1.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)),
    ] {
        assert_eq!(Spacecraft::new(mass, inertia), None, "{mass} {inertia}");
    }
    let arm = Arm::parse(&bare, &Selection { spacecraft, ..with_tip("tool") }).unwrap();
    assert_eq!(arm.spacecraft.body.mass, 50.0);
    close(arm.spacecraft.body.centre, [0.0; 3]);
}

#[test]
fn a_base_further_out_leaves_the_rest_away() {
    let selection = Selection { base: Some("upper".to_owned()), ..with_tip("tool") };
    let arm = Arm::parse(&arm(), &selection).unwrap();
    assert_eq!(arm.spacecraft.body.mass, 5.0);
    assert_eq!(arm.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>(), ["extend"]);
    close(arm.joints[0].place, [2.0, 0.0, 0.0]);
}

#[test]
fn what_is_wrong_is_named() {
    let cases: [(&str, &str, &str); 24] = [
        ("robot", "model", "line 2: <model>, expected <robot>"),
        ("</robot>", "", "not XML: "),
        (r#"<mass value="4"/>"#, "", "line 8: upper has no <mass> in <inertial>"),
        (
            r#"<mass value="4"/>"#,
            r#"<mass value="4kg"/>"#,
            "line 8: upper: mass value = \"4kg\", expected a number of at most 1e12",
        ),
        (
            r#"<mass value="4"/>"#,
            r#"<mass value="inf"/>"#,
            "line 8: upper: mass value = \"inf\", expected a number of at most 1e12",
        ),
        (r#"<mass value="4"/>"#, r#"<mass value="-4"/>"#, "line 8: upper: mass value = \"-4\", expected a number >= 0"),
        (
            r#"axis xyz="1 0 0""#,
            r#"axis xyz="1 0""#,
            "line 10: shoulder: axis xyz = \"1 0\", expected three numbers of at most 1e12",
        ),
        (r#"axis xyz="1 0 0""#, r#"axis xyz="0 0 0""#, "link \"upper\": link 2: joint axis has no direction"),
        (r#"type="prismatic""#, r#"type="planar""#, "line 15: joint \"extend\" is planar, expected revolute"),
        (r#"name="extend""#, r#"name="pan""#, "line 15: joint \"pan\" is there twice"),
        (r#"<link name="slider">"#, r#"<link name="upper">"#, "line 14: link \"upper\" is there twice"),
        (r#"<child link="slider"/>"#, r#"<child link="slide"/>"#, "line 15: joint \"extend\": no link \"slide\""),
        (r#"<child link="slider"/>"#, r#"<child link="upper"/>"#, "line 15: link \"upper\" has a second parent"),
        (r#"ixx="0.3""#, r#"ixx="-9""#, "inertia is not a symmetric positive definite matrix"),
        (
            r#"<parent link="bus"/>"#,
            r#"<parent link="tool"/>"#,
            "line 7: link \"mount\" is outboard of itself, expected a tree",
        ),
        (
            r#"lower="-1" upper="2""#,
            r#"lower="2" upper="-1""#,
            "line 11: shoulder: limit upper = \"-1\", expected no less than lower",
        ),
        (r#"effort="30""#, r#"effort="-30""#, "line 11: shoulder: limit effort = \"-30\", expected a number >= 0"),
        (r#"velocity="0.5""#, r#"velocity="-0.5""#, "shoulder: limit velocity = \"-0.5\", expected a number >= 0"),
        (
            r#"<mass value="80"/>"#,
            r#"<mass value="1e13"/>"#,
            "bus: mass value = \"1e13\", expected a number of at most",
        ),
        (r#"<link name="tool"/>"#, r#"<link name=""/>"#, "line 17: a link: name = \"\", expected a name"),
        (r#"<mass value="4"/>"#, r#"<mass/>"#, "line 8: upper has no value in <mass>"),
        (r#"<mass value="4"/>"#, r#"<mass value="4"/><mass value="5"/>"#, "line 8: <mass> of \"upper\" is there twice"),
        (
            r#"<axis xyz="0 0 2"/>"#,
            r#"<axis xyz="0 0 2"/><mimic joint="shoulder"/>"#,
            "line 15: joint \"extend\" mimics joint \"shoulder\", expected joints that move by themselves",
        ),
        (
            r#"<robot name="test arm">"#,
            r#"<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="a"><xacro:include filename="b"/>"#,
            "line 2: an element of Xacro, expected the URDF that xacro makes of it",
        ),
    ];
    for (from, to, expected) in cases {
        let text = arm();
        assert!(text.contains(from), "{from}");
        let text = text.replace(from, to);
        let error = Arm::parse(&text, &with_tip("tool")).and_then(|arm| arm.space_manipulator::<2>()).unwrap_err();
        assert!(error.to_string().contains(expected), "{to}: {error}");
    }
    let error = |selection: &Selection| Arm::parse(&arm(), selection).unwrap_err().to_string();
    assert_eq!(
        error(&Selection::default()),
        "the arm ends in \"camera\", \"tool\", expected one to be named as its tip"
    );
    let fixed = Selection { base: Some("tool".to_owned()), ..Selection::default() };
    assert_eq!(error(&fixed), "no joint outboard of link \"tool\" moves, expected an arm");
    let empty = Arm::parse("<robot name=\"none\"/>", &Selection::default()).unwrap_err();
    assert_eq!(empty.to_string(), "line 1: <robot> has no <link>");
    assert!(error(&with_tip("hand")).starts_with("no link \"hand\", expected one of \"bus\", \"camera\""));
    assert_eq!(error(&with_tip("bus")), "link \"bus\" is not outboard of link \"bus\"");
    let three = Arm::parse(&arm(), &with_tip("tool")).unwrap().space_manipulator::<3>().unwrap_err();
    assert_eq!(three.to_string(), "2 joints between base and tip, expected 3");
}

/// Names that XML escapes, and names that the formats or this crate use themselves.
#[test]
fn any_name_is_written_so_that_it_reads_back() {
    let text = arm()
        .replace("test arm", "a &quot;b&quot; &lt;c&gt; &amp; d")
        .replace("\"shoulder\"", "\"tool\"")
        .replace("\"extend\"", "\"base\"")
        .replace("\"slider\"", "\"world\"")
        .replace("\"upper\"", "\"j&#9;1\"");
    let first = Arm::parse(&text, &with_tip("tool")).unwrap();
    let (manipulator, joints) = first.space_manipulator::<2>().unwrap();
    let links = first.joints.iter().zip(&first.links);
    let names = Names {
        robot: first.name.clone(),
        first: "tool".to_owned(),
        links: links.map(|(joint, link)| (joint.name.clone(), joint.limits, link.name.clone())).collect(),
    };
    let chain = Chain::space_manipulator(&names, &manipulator, &joints);
    let second = Arm::parse(&write_urdf(&chain), &Selection::default()).unwrap();
    assert_eq!(second.name, "a \"b\" <c> & d");
    assert_eq!(second.links[0].name, "j\t1");
    assert_eq!(second.joints[0].name, "tool");
    assert_eq!(second.links[1].merged, ["tool_"]);
    let mjcf = write_mjcf(&chain);
    for expected in
        [r#"<freejoint name="base_"/>"#, r#"<body name="world_""#, r#"model="a &quot;b&quot; &lt;c&gt; &amp; d""#]
    {
        assert!(mjcf.contains(expected), "no {expected} in\n{mjcf}");
    }
}

/// A gripper beside the arm mimics a joint in many files: it stands still, as all there do.
#[test]
fn a_joint_beside_the_arm_may_mimic_another() {
    let pan = r#"<child link="camera"/>"#;
    let text = arm().replace(pan, &format!("{pan}<mimic joint=\"shoulder\"/>"));
    assert_eq!(Arm::parse(&text, &with_tip("tool")).unwrap().locked, ["pan"]);
}

/// No body has moments of 1, 1 and 3 kg m2; 0.3, 0.2 and 0.1 is a flat plate: just one.
#[test]
fn an_inertia_that_no_body_has_is_told() {
    let told = |text: &str| {
        let arm = Arm::parse(text, &with_tip("tool")).unwrap();
        [&arm.spacecraft].into_iter().chain(&arm.links).map(|link| link.has_impossible_inertia()).collect::<Vec<_>>()
    };
    assert_eq!(told(&arm()), [false, false, false]);
    let slider = r#"<mass value="2"/><inertia ixx="0.3""#;
    assert!(arm().contains(slider));
    assert_eq!(told(&arm().replace(slider, r#"<mass value="2"/><inertia ixx="0.31""#)), [false, false, true]);
}

/// Links in a row, all fixed to each other: the work grows with their number, not with its square.
#[test]
fn thousands_of_fixed_links_become_one_body() {
    const LINKS: usize = 20_000;
    let body = r#"<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>"#;
    let links: String = (0..=LINKS).map(|n| format!("<link name=\"l{n}\">{body}</link>")).collect();
    let joint = |n: usize| {
        let kind = if n == 1 { "continuous" } else { "fixed" };
        format!("<joint name=\"j{n}\" type=\"{kind}\"><parent link=\"l{}\"/><child link=\"l{n}\"/></joint>", n - 1)
    };
    let joints: String = (1..=LINKS).map(joint).collect();
    let arm = Arm::parse(&format!("<robot name=\"row\">{links}{joints}</robot>"), &Selection::default()).unwrap();
    assert_eq!((arm.joints.len(), arm.links[0].body.mass), (1, LINKS as f64));
}
