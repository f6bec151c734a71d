//! COLLADA: vertex positions, with the unit of the file and the transformations of its scene.
//!
//! The `up_axis` is not applied, as in ROS viewers: the axes of the file are the axes of the link.

use nalgebra::{Matrix4, Rotation3, Unit, Vector3};
use roxmltree::{Document, Node, ParsingOptions};

use crate::markup::{MAX_ATTRIBUTES, crowded};

/// Maximum number of XML nodes.
const MAX_NODES: u32 = 4_000_000;

/// Returns all vertices that the scene shows, or all vertices of the file if it has no scene.
pub(super) fn vertices(text: &str) -> Result<Vec<Vector3<f64>>, String> {
    if crowded(text).is_some() {
        return Err(format!("an element has more than {MAX_ATTRIBUTES} attributes"));
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| e.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err("it is no COLLADA file".into());
    }
    let unit = elements(root, "unit")
        .find_map(|u| u.attribute("meter"))
        .map_or(Ok(1.0), |meter| meter.trim().parse::<f64>().map_err(|_| "its unit is broken"))?;
    let mut geometries = Vec::new();
    for geometry in elements(root, "geometry") {
        geometries.push((geometry.attribute("id").unwrap_or(""), positions(geometry)?));
    }
    if ["instance_node", "instance_controller"].iter().any(|n| elements(root, n).next().is_some()) {
        return Err("its scene refers to nodes or skins elsewhere, which is not read".into());
    }
    let mut found = Vec::new();
    let mut shown = false;
    for scene in elements(root, "visual_scene") {
        // Depth first without recursion, because the file decides on the depth of the nesting.
        let mut stack: Vec<(Node, Matrix4<f64>)> = children(scene, "node").map(|n| (n, Matrix4::identity())).collect();
        while let Some((node, above)) = stack.pop() {
            let X = above * transform(node)?;
            for instance in children(node, "instance_geometry") {
                let id = instance.attribute("url").unwrap_or("").trim_start_matches('#');
                shown = true;
                for (_, vertices) in geometries.iter().filter(|(name, _)| *name == id) {
                    found.extend(vertices.iter().map(|v| X.transform_point(&(*v).into()).coords));
                }
            }
            stack.extend(children(node, "node").map(|n| (n, X)));
        }
    }
    if !shown {
        found = geometries.into_iter().flat_map(|(_, vertices)| vertices).collect();
    }
    for vertex in &mut found {
        *vertex *= unit;
    }
    Ok(found)
}

fn elements<'a, 'i: 'a>(node: Node<'a, 'i>, name: &str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.descendants().filter(move |n| n.tag_name().name() == name)
}

fn children<'a, 'i: 'a>(node: Node<'a, 'i>, name: &str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |n| n.tag_name().name() == name)
}

fn numbers(node: Node) -> Result<Vec<f64>, String> {
    node.text()
        .unwrap_or("")
        .split_whitespace()
        .map(|word| word.parse().map_err(|_| format!("`{word}` in it is no number")))
        .collect()
}

/// Returns the positions that the `<vertices>` of a geometry refer to.
fn positions(geometry: Node) -> Result<Vec<Vector3<f64>>, String> {
    let mut found = Vec::new();
    for input in elements(geometry, "vertices").flat_map(|v| children(v, "input")) {
        if input.attribute("semantic") != Some("POSITION") {
            continue;
        }
        let id = input.attribute("source").unwrap_or("").trim_start_matches('#');
        let Some(source) = elements(geometry, "source").find(|s| s.attribute("id") == Some(id)) else {
            return Err(format!("it has no source `{id}`"));
        };
        let stride = elements(source, "accessor")
            .find_map(|a| a.attribute("stride")?.parse::<usize>().ok())
            .filter(|s| *s >= 3)
            .unwrap_or(3);
        for array in elements(source, "float_array") {
            let values = numbers(array)?;
            let vertices = values.chunks(stride).filter(|c| c.len() >= 3);
            found.extend(vertices.map(|c| Vector3::new(c[0], c[1], c[2])));
        }
    }
    Ok(found)
}

/// Returns the product of a node's transformations, in file order.
fn transform(node: Node) -> Result<Matrix4<f64>, String> {
    let mut X = Matrix4::identity();
    for element in node.children().filter(Node::is_element) {
        let name = element.tag_name().name();
        if !["matrix", "translate", "rotate", "scale", "skew", "lookat"].contains(&name) {
            continue;
        }
        let x = numbers(element)?;
        X *= match (name, x.as_slice()) {
            ("matrix", x) if x.len() == 16 => Matrix4::from_row_slice(x),
            ("translate", &[x, y, z]) => Matrix4::new_translation(&Vector3::new(x, y, z)),
            ("scale", &[x, y, z]) => Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z)),
            ("rotate", &[x, y, z, degrees]) => match Unit::try_new(Vector3::new(x, y, z), 1e-12) {
                Some(axis) => Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous(),
                None => Matrix4::identity(),
            },
            _ => return Err(format!("its `<{name}>` is not understood")),
        };
    }
    Ok(X)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(scene: &str) -> String {
        format!(
            r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
            <asset><unit name="millimeter" meter="0.001"/><up_axis>Y_UP</up_axis></asset>
            <library_geometries><geometry id="g"><mesh>
              <source id="n"><float_array id="na" count="3">0 0 1</float_array></source>
              <source id="p"><float_array id="pa" count="6">1000 0 0 0 2000 500</float_array>
                <technique_common><accessor source="#pa" count="2" stride="3"/></technique_common>
              </source>
              <vertices id="v"><input semantic="NORMAL" source="#n"/>
                <input semantic="POSITION" source="#p"/></vertices>
            </mesh></geometry></library_geometries>{scene}</COLLADA>"##
        )
    }

    #[test]
    fn unit_and_positions() {
        let expected = vec![Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 2.0, 0.5)];
        assert_eq!(vertices(&file("")).unwrap(), expected);
    }

    #[test]
    fn scene_transformations_nest() {
        let scene = r##"<library_visual_scenes><visual_scene id="s"><node>
            <translate>0 0 1000</translate><rotate>0 0 1 90</rotate>
            <node><scale>2 2 2</scale><instance_geometry url="#g"/></node>
            </node></visual_scene></library_visual_scenes>"##;
        let found = vertices(&file(scene)).unwrap();
        // (1, 0, 0) doubled, turned onto y, raised by one.
        assert!((found[0] - Vector3::new(0.0, 2.0, 1.0)).norm() < 1e-12, "{found:?}");
        assert!((found[1] - Vector3::new(-4.0, 0.0, 2.0)).norm() < 1e-12, "{found:?}");
    }

    #[test]
    fn what_is_not_understood_is_said() {
        assert!(vertices("<x/>").is_err());
        assert!(vertices(&file("<instance_controller/>")).is_err());
        assert!(vertices(&file("").replace("1000", "10OO")).unwrap_err().contains("10OO"));
    }
}
