//! Meshes of collision shapes: found, bounded, or dropped with a warning.

use std::fs;
use std::path::PathBuf;

use hierarq_robot::{Data, Model, Options, Shape, UrdfCode};
use nalgebra::Vector3;

/// A folder that removes itself.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("hierarq-{name}-{}", std::process::id()));
        fs::create_dir_all(path.join("my_robot/meshes")).unwrap();
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const CUBE: &str = "v -1 -1 -4\nv 1 -1 -4\nv 1 1 4\nv -1 1 4\nv 0 0 0\n";

fn robot(address: &str) -> String {
    format!(
        "<robot name='r'><link name='l'><collision><origin xyz='1 2 3' rpy='0.3 0 0'/><geometry>\
         <mesh filename='{address}' scale='0.1 0.1 0.1'/></geometry></collision></link></robot>"
    )
}

#[test]
fn meshes_are_found_and_bounded() {
    let folder = Folder::new("found");
    let file = folder.0.join("my_robot/meshes/a link.obj");
    fs::write(&file, CUBE).unwrap();
    let inside = folder.0.join("my_robot");
    let cases = [
        ("package://my_robot/meshes/a link.obj", Some(folder.0.clone()), None),
        ("package://my_robot/meshes/a%20link.obj", Some(inside.clone()), None),
        ("meshes/a link.obj", None, Some(inside.clone())),
        // A URDF in its package, and one in a package beside it.
        ("package://my_robot/meshes/a link.obj", None, Some(inside.join("urdf"))),
        ("package://my_robot/meshes/a link.obj", None, Some(folder.0.join("another_robot/urdf/arms"))),
    ];
    let absolute = format!("file://{}", file.display());
    for (address, package, urdf_dir) in cases.into_iter().chain([(absolute.as_str(), None, None)]) {
        let options =
            Options { read_meshes: true, urdf_dir, package_paths: package.into_iter().collect(), ..Options::default() };
        let (model, warnings) = Model::from_urdf(&robot(address), &options).unwrap();
        assert!(warnings.is_empty(), "{address}: {warnings:?}");
        let placed = &model.links[0].collision[0];
        let Shape::Capsule { radius, half_length } = placed.shape else { panic!("no capsule") };
        let X = Data::new(&model).pose(model.root()) * placed.origin;
        let X_WM = nalgebra::Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::x() * 0.3);
        for line in CUBE.lines() {
            let v: Vec<f64> = line[2..].split(' ').map(|x| 0.1 * x.parse::<f64>().unwrap()).collect();
            let p = X_WM.transform_point(&nalgebra::Point3::new(v[0], v[1], v[2]));
            let mut local = X.inverse_transform_point(&p).coords;
            local.z -= local.z.clamp(-half_length, half_length);
            assert!(local.norm() <= radius + 1e-12, "{local} outside {radius}");
        }
    }
}

#[test]
fn what_cannot_be_read_is_dropped_with_a_warning() {
    let folder = Folder::new("dropped");
    fs::write(folder.0.join("broken.stl"), "no mesh").unwrap();
    fs::write(folder.0.join("empty.obj"), "").unwrap();
    fs::write(folder.0.join("mesh.ply"), "ply").unwrap();
    let with = Options {
        read_meshes: true,
        urdf_dir: Some(folder.0.clone()),
        package_paths: vec![folder.0.clone()],
        ..Options::default()
    };
    let without = Options { read_meshes: false, ..with.clone() };
    for (address, options, code) in [
        ("broken.stl", &with, UrdfCode::MeshUnreadable),
        ("empty.obj", &with, UrdfCode::MeshUnreadable),
        ("mesh.ply", &with, UrdfCode::MeshUnreadable),
        ("absent.stl", &with, UrdfCode::MeshMissing),
        ("my_robot", &with, UrdfCode::MeshMissing),
        ("/dev/zero", &with, UrdfCode::MeshMissing),
        ("package://my_robot/absent.stl", &with, UrdfCode::MeshMissing),
        ("package://other/absent.stl", &with, UrdfCode::MeshMissing),
        ("package://", &with, UrdfCode::MeshMissing),
        ("http://example.org/a.stl", &with, UrdfCode::MeshMissing),
        ("broken.stl", &without, UrdfCode::MeshNotRead),
    ] {
        let text = robot(address);
        let (model, warnings) = Model::from_urdf(&text, options).unwrap();
        assert!(model.links[0].collision.is_empty(), "{address}");
        assert_eq!(warnings.iter().map(|w| w.code).collect::<Vec<_>>(), [code], "{address}");
        assert_eq!(&text[warnings[0].span.clone()], address);
    }
}

#[test]
fn a_package_that_is_nowhere_is_said_once() {
    let link = |i: usize, address: &str| {
        let joint = format!("<joint name=\"j{i}\" type=\"fixed\"><parent link=\"l0\"/><child link=\"l{i}\"/></joint>");
        format!(
            "<link name=\"l{i}\"><collision><geometry><mesh filename=\"{address}\"/></geometry></collision></link>{}",
            if i == 0 { String::new() } else { joint }
        )
    };
    let options = Options { read_meshes: true, urdf_dir: Some(std::env::temp_dir()), ..Options::default() };
    let texts = |addresses: &[&str]| -> Vec<String> {
        let links: String = addresses.iter().enumerate().map(|(i, a)| link(i, a)).collect();
        let (model, warnings) = Model::from_urdf(&format!("<robot name=\"r\">{links}</robot>"), &options).unwrap();
        assert!(model.links.iter().all(|l| l.collision.is_empty()));
        assert!(warnings.iter().all(|w| w.code == UrdfCode::MeshMissing && w.help.is_some()));
        warnings.into_iter().map(|w| w.text).collect()
    };
    let [a, b, c] = ["package://lost/a.stl", "package://lost/b.stl", "package://lost/c.stl"];
    assert_eq!(
        texts(&[a, b, c]),
        ["mesh `package://lost/a.stl` and 2 others not found; their links have no shapes there"]
    );
    assert_eq!(
        texts(&[a, b]),
        ["mesh `package://lost/a.stl` and another one not found; their links have no shapes there"]
    );
    // Another package, and files without one, have another cause.
    let other = texts(&[a, "package://gone/a.stl", "nowhere_1.stl", "nowhere_2.stl", b]);
    assert_eq!(other.len(), 4, "{other:?}");
}
