//! A city as a scene of Mitsuba 3, in the form that Sionna RT loads: XML beside meshes in PLY
//! files.
//!
//! # References
//! Sionna RT: materials by the names `mat-itu_…` of ITU-R P.2040. Turk 1994, the PLY file format.

use std::path::Path;

use super::city_mesh::Mesh;
use super::files::{MESHES, mesh_name};
use super::{Batch, with_suffix};
use crate::error::Result;
use crate::formats::xml_text;

/// Name of the one material. Concrete of ITU-R P.2040 is defined from 1 to 100 GHz. Kinds of ground
/// are defined to 10 GHz only, beyond which a simulator would refuse the scene.
const MATERIAL: &str = "mat-itu_concrete";

/// A scene ready for files.
#[derive(Debug, Clone, Copy)]
pub struct MitsubaScene<'a> {
    /// The ground.
    pub ground: &'a Mesh,
    /// All buildings.
    pub buildings: &'a Mesh,
    /// Place of the local origin, in words.
    pub origin: &'a str,
    /// Provenance as one JSON text.
    pub provenance: &'a str,
}

/// Adds the scene, its meshes `NAME_ground.ply` and `NAME_buildings.ply`, and its provenance to a
/// batch.
///
/// # Errors
/// Errors of [`Batch::add`].
pub fn add_mitsuba(batch: &mut Batch, scene: &MitsubaScene<'_>, path: &Path) -> Result<()> {
    let meshes = [scene.ground, scene.buildings];
    // Mitsuba refuses a mesh without triangles.
    let named: Vec<(&str, &Mesh)> = MESHES.into_iter().zip(meshes).filter(|(_, mesh)| !mesh.faces.is_empty()).collect();
    for (name, mesh) in &named {
        batch.add(&mesh_name(path, name), &ply(mesh, scene.origin))?;
    }
    let names: Vec<&str> = named.iter().map(|(name, _)| *name).collect();
    batch.add(path, xml(&names, scene.origin, path).as_bytes())?;
    batch.add(&with_suffix(path, ".json"), scene.provenance.as_bytes())
}

fn xml(meshes: &[&str], origin: &str, path: &Path) -> String {
    // Two hyphens would end a comment early.
    let origin = xml_text(origin).replace("--", "- -");
    let mut text = format!(
        "<scene version=\"2.1.0\">\n  <!-- {origin} -->\n  <integrator type=\"path\"/>\n  \
         <emitter type=\"constant\"/>\n  <bsdf type=\"twosided\" id=\"{MATERIAL}\">\n    \
         <bsdf type=\"diffuse\">\n      <rgb name=\"reflectance\" value=\"0.6 0.6 0.6\"/>\n    </bsdf>\n  </bsdf>\n"
    );
    for mesh in meshes {
        let file = mesh_name(path, mesh);
        let file = xml_text(&file.file_name().unwrap_or_default().to_string_lossy());
        text += &format!(
            "  <shape type=\"ply\" id=\"mesh-{mesh}\">\n    <string name=\"filename\" value=\"{file}\"/>\n    \
             <boolean name=\"face_normals\" value=\"true\"/>\n    <ref id=\"{MATERIAL}\" name=\"bsdf\"/>\n  </shape>\n"
        );
    }
    text + "</scene>\n"
}

fn ply(mesh: &Mesh, origin: &str) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        origin.replace(char::is_control, " "),
        mesh.vertices.len(),
        mesh.faces.len()
    )
    .into_bytes();
    bytes.extend(mesh.vertices.iter().flatten().flat_map(|v| v.to_le_bytes()));
    for face in &mesh.faces {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|k| k.to_le_bytes()));
    }
    bytes
}
