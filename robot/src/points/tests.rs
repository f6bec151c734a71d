//! The same points in each form of file, and files that are broken.

use super::*;

const EXPECTED: [[f64; 3]; 3] = [[0.5, 1.0, -2.0], [3.5, -4.25, 5.0], [0.0, 0.125, 1e3]];

fn same(points: &[Vector3<f64>]) {
    assert_eq!(points, EXPECTED.map(Vector3::from));
}

/// Header, and a row of a double, a byte and three floats for each point.
fn ply_binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut file = format!(
        "ply\r\nformat binary_{order}_endian 1.0\r\ncomment a scan\r\nelement vertex 3\r\nproperty double z\r\nproperty uchar \
         red\r\nproperty float x\r\nproperty float y\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n"
    )
    .into_bytes();
    for [x, y, z] in EXPECTED {
        let (x, y) = (x as f32, y as f32);
        match big {
            true => file.extend(z.to_be_bytes().into_iter().chain([7]).chain(x.to_be_bytes()).chain(y.to_be_bytes())),
            false => file.extend(z.to_le_bytes().into_iter().chain([7]).chain(x.to_le_bytes()).chain(y.to_le_bytes())),
        }
    }
    file.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    file
}

fn pcd(data: &str) -> String {
    format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity normal\nSIZE 4 4 4 2 4\nTYPE F F F U F\nCOUNT 1 1 1 1 3\nWIDTH 3\n\
         HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA {data}\n"
    )
}

fn pcd_binary() -> Vec<u8> {
    let mut file = pcd("binary").into_bytes();
    for p in EXPECTED {
        p.iter().for_each(|x| file.extend((*x as f32).to_le_bytes()));
        file.extend(9u16.to_le_bytes());
        file.extend([0; 12]);
    }
    file
}

#[test]
fn each_form_gives_the_same_points() {
    same(&ply::points(&ply_binary(false)).unwrap());
    same(&ply::points(&ply_binary(true)).unwrap());
    let ascii = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  end_header\n0.5 1 -2\n3.5 -4.25 5\n\n0 0.125 1e3\n";
    same(&ply::points(ascii).unwrap());
    same(&pcd::points(&pcd_binary()).unwrap());
    let text = pcd("ascii") + "0.5 1 -2 9 0 0 0\n3.5 -4.25 5 9 0 0 0\n0 0.125 1e3 9 0 0 0\n";
    same(&pcd::points(text.as_bytes()).unwrap());
    same(&xyz::points("# x y z\n0.5 1 -2 200 100 0\n3.5,-4.25,5\n\n0;0.125;\t1e3\n").unwrap());
}

#[test]
fn numbers_of_each_type() {
    let header = "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty short x\nproperty uint8 y\nproperty int z\n\
                  end_header\n";
    let mut file = header.as_bytes().to_vec();
    file.extend((-3i16).to_be_bytes());
    file.push(200);
    file.extend((-70_000i32).to_be_bytes());
    assert_eq!(ply::points(&file).unwrap(), [Vector3::new(-3.0, 200.0, -70_000.0)]);
}

/// Reasons to refuse a file, each with a word of the message.
#[test]
fn broken_files_say_what_is_wrong() {
    let refused = |found: Result<Vec<Vector3<f64>>, String>, word: &str| {
        let why = found.unwrap_err();
        assert!(why.contains(word), "{why}");
    };
    let whole = ply_binary(false);
    refused(ply::points(&whole[..whole.len() - 20]), "2 of its 3 points");
    refused(ply::points(&whole[..90]), "end_header");
    refused(ply::points(b"solid"), "first line");
    refused(ply::points(b"ply\nend_header\n"), "format");
    refused(ply::points(b"ply\nformat ascii 1.0\nend_header\n"), "element vertex");
    let start = "ply\nformat ascii 1.0\nelement vertex";
    refused(ply::points(format!("{start} 1\nproperty float x\nend_header\n1\n").as_bytes()), "x, y and z");
    refused(ply::points(format!("{start} -1\nend_header\n").as_bytes()), "-1");
    refused(ply::points(format!("{start} 1\nproperty half x\nend_header\n").as_bytes()), "half");
    refused(ply::points(format!("{start} 1\nproperty list uchar int x\nend_header\n").as_bytes()), "list");
    refused(ply::points(b"ply\nformat ascii 1.0\nelement face 3\nelement vertex 1\nend_header\n"), "before");
    let coordinates = "property float x\nproperty float y\nproperty float z\nend_header\n";
    refused(ply::points(format!("{start} 1\n{coordinates}1 2\n").as_bytes()), "too few");
    refused(ply::points(format!("{start} 1\n{coordinates}1 2 l\n").as_bytes()), "`l`");
    // A count that nothing could hold reserves nothing.
    refused(ply::points(format!("{start} 99999999999999\n{coordinates}1 2 3\n").as_bytes()), "1 of its 99999999999999");

    let whole = pcd_binary();
    refused(pcd::points(&whole[..whole.len() - 1]), "2 of its 3 points");
    refused(pcd::points(b"1 2 3\n4 5 6\n"), "DATA");
    refused(pcd::points(pcd("binary_compressed").as_bytes()), "compressed");
    refused(pcd::points(pcd("zip").as_bytes()), "neither");
    refused(pcd::points(pcd("ascii").replace("SIZE 4 4", "SIZE 4").as_bytes()), "other numbers");
    refused(pcd::points(pcd("ascii").replace("SIZE 4 4", "SIZE 4 3").as_bytes()), "3 bytes");
    refused(pcd::points(pcd("ascii").replace("TYPE F", "TYPE Q").as_bytes()), "`Q`");
    refused(pcd::points(pcd("ascii").replace("x y z", "r g b").as_bytes()), "x, y and z");
    refused(pcd::points(pcd("binary").replace("1 1 1 1 3", "1 1 1 1 99999999999999").as_bytes()), "bytes");

    refused(xyz::points("1 2\n"), "line 1");
    refused(xyz::points("1 2 3\nx y z\n"), "line 2");
}

#[test]
fn points_that_are_missing_are_counted_and_infinite_ones_refused() {
    let folder = std::env::temp_dir().join(format!("hierarq-points-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let read = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).unwrap();
        points(&folder.join(name))
    };
    let found = read("a.xyz", "0 0 1\nnan 0 1\n0 NaN nan\n1 1 1\n").unwrap();
    assert_eq!((found.points.len(), found.missing), (2, 2));
    assert!(read("b.xyz", "nan nan nan\n").unwrap_err().contains("all of its points"));
    assert!(read("c.xyz", "").unwrap_err().contains("no point"));
    assert!(read("d.xyz", "0 0 inf\n").unwrap_err().contains("infinite"));
    assert!(read("e.las", "0 0 1\n").unwrap_err().contains("`las`"));
    assert!(points(&folder.join("none.ply")).is_err());
    let many: String = (0..50_000).map(|i| format!("{} 0 1\n", f64::from(i) * 1e-3)).collect();
    assert_eq!(read("many.xyz", &many).unwrap().points.len(), 50_000);
    std::fs::remove_dir_all(&folder).unwrap();
}
