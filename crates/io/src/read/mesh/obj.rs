//! Wavefront OBJ: among its many statements only vertices (`v`) and faces (`f`) define surfaces.
//!
//! # References
//! Wavefront, Advanced Visualizer manual, appendix B1 (1995): negative numbers count from the last
//! vertex.

use super::faces::Mesh;
use crate::error::{Error, Place, Result};
use crate::input::Input;

/// Reads the vertices and faces of a file.
pub(super) fn read(input: &Input) -> Result<Mesh> {
    let bytes = input.read()?;
    // Names of materials may be in any code page; numbers are the same in all of them.
    let text = String::from_utf8_lossy(&bytes);
    let mut mesh = Mesh::default();
    let mut lines = text.lines().enumerate();
    while let Some((k, line)) = lines.next() {
        let mut statement = line.to_string();
        while statement.ends_with('\\') {
            statement.pop();
            let Some((_, more)) = lines.next() else { break };
            statement.push(' ');
            statement.push_str(more);
        }
        add(&mut mesh, &statement).map_err(|found| {
            let what = format!("{found}, wanted a Wavefront OBJ mesh");
            Error::malformed(input, what).at(Place::Line(k as u64 + 1))
        })?;
    }
    Ok(mesh)
}

/// Reads one statement; the error names its fault.
fn add(mesh: &mut Mesh, statement: &str) -> std::result::Result<(), String> {
    if statement.contains('\0') {
        return Err("a binary file".into());
    }
    let mut words = statement.split('#').next().unwrap_or_default().split_whitespace();
    match words.next() {
        Some("v") => {
            let mut vertex = [0.0; 3];
            for (coordinate, axis) in vertex.iter_mut().zip(["x", "y", "z"]) {
                let word = words.next().ok_or_else(|| format!("a vertex without {axis}"))?;
                *coordinate = word.parse().map_err(|_| format!("a vertex whose {axis} is `{word}`"))?;
            }
            mesh.vertices.push(vertex);
            Ok(())
        }
        Some("f") => {
            let corners = words.map(|word| corner(word, mesh.vertices.len()));
            let corners = corners.collect::<std::result::Result<Vec<u32>, String>>()?;
            if corners.len() < 3 {
                return Err(format!("a face of {} vertices", corners.len()));
            }
            mesh.add_face(&corners)
        }
        _ => Ok(()),
    }
}

/// Returns the number of a vertex, counted from 0, from a word such as `7`, `7/1/3` or `-1`.
fn corner(word: &str, n_vertices: usize) -> std::result::Result<u32, String> {
    let wrong = || format!("a face whose corner is `{word}`, of {n_vertices} vertices so far");
    let number: i64 = word.split('/').next().unwrap_or_default().parse().map_err(|_| wrong())?;
    let from_start = if number < 0 { i64::try_from(n_vertices).map_err(|_| wrong())? + number } else { number - 1 };
    u32::try_from(from_start).ok().filter(|k| (*k as usize) < n_vertices).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_count_from_either_end_and_lines_go_on() {
        let mut mesh = Mesh::default();
        for line in ["# a roof", "v 0 0 5 1 0 0", "v 4 0 5", "v 4 4 5.5", "vt 0 0", "f 1/1 2/1/1 -1//2", "usemtl é"] {
            add(&mut mesh, line).expect(line);
        }
        assert_eq!(mesh.vertices.get(2), Some(&[4.0, 4.0, 5.5]));
        assert_eq!((mesh.corners.as_slice(), mesh.ends.as_slice()), ([0, 1, 2].as_slice(), [3].as_slice()));
        for (line, found) in [
            ("f 1 2 9", "corner is `9`"),
            ("f 1 2 0", "corner is `0`"),
            ("f 1 2 -4", "corner is `-4`"),
            ("f 1 2", "a face of 2"),
            ("v 1 2", "without z"),
            ("v 1 2 up", "z is `up`"),
        ] {
            assert!(add(&mut mesh, line).is_err_and(|e| e.contains(found)), "{line}");
        }
    }
}
