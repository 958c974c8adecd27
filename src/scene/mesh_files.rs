//! Loads the mesh files of a scene, each once.

use super::copies::KnownFiles;
use super::named_files::{found, unreadable};
use super::obj::{self, MeshFile};
use crate::error::{Error, Remarks, SourceText, Span};
use crate::file_path::KnownFolders;
use crate::input::read_whole;
use crate::memory::Budget;
use crate::objects::Mesh;
use crate::plan::Plan;
use crate::scene_file::At;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest mesh file that is read. A triangle takes two bytes at least, so their numbers fit into 32 bits.
const MAX_MESH_BYTES: u64 = 4 << 30;
/// Bytes of memory for a byte of a mesh file, while the mesh is read and its tree is built: 3.0 were measured with a
/// million triangles.
const MEMORY_FOR_A_BYTE: u64 = 4;
/// Further bytes, if the file is not plain: 3.4 were measured.
const MEMORY_FOR_AN_UNUSUAL_BYTE: u64 = 4;
/// Bytes of memory for a triangle and its trees, with its share of the positions: 97 to 143 were measured. A file of short lines
/// has more of them than its bytes tell.
const MEMORY_FOR_A_TRIANGLE: u64 = 150;

/// The meshes that were loaded so far.
pub(super) struct LoadedMeshes<'a> {
    pub source: &'a Arc<SourceText>,
    pub folder: &'a Path,
    pub plan: &'a Plan,
    pub budget: &'a mut Budget,
    pub meshes: Vec<Mesh>,
    pub mesh_files: Vec<MeshFile>,
    pub remarks: Remarks,
    /// What was left out and why, a sentence each.
    pub left_out: Vec<String>,
    folders: KnownFolders,
    /// Meshes by the path of their file.
    by_path: HashMap<PathBuf, u32>,
    /// Meshes by the bytes of their file.
    by_bytes: KnownFiles,
}

impl<'a> LoadedMeshes<'a> {
    /// Begins without meshes.
    pub fn new(source: &'a Arc<SourceText>, folder: &'a Path, plan: &'a Plan, budget: &'a mut Budget) -> Self {
        Self {
            source,
            folder,
            plan,
            budget,
            meshes: Vec::new(),
            mesh_files: Vec::new(),
            remarks: Remarks::default(),
            left_out: Vec::new(),
            folders: KnownFolders::default(),
            by_path: HashMap::new(),
            by_bytes: KnownFiles::default(),
        }
    }

    /// Returns the index of a mesh. Each file is loaded once.
    ///
    /// # Errors
    /// [`Error::Source`] for a file that cannot be read, and for a mistake in it.
    pub fn index_of(&mut self, name: &At<String>) -> Result<u32, Error> {
        let as_written = self.folder.join(&name.value);
        if let Some(&known) = self.by_path.get(&as_written) {
            return Ok(known);
        }
        let path = found(self.source, self.folder, name, &mut self.folders, &mut self.remarks);
        let index = match self.by_path.get(&path) {
            Some(&known) => known,
            None => self.load(&path, name)?,
        };
        self.by_path.insert(as_written, index);
        Ok(index)
    }

    fn reserve(&mut self, bytes: u64, mesh: Span) -> Result<(), Error> {
        self.budget.add_mesh(bytes).map_err(|error| self.source.error(mesh, error.to_string()))
    }

    /// Reads the mesh file at `path`, which the scene calls `name`.
    fn load(&mut self, path: &Path, name: &At<String>) -> Result<u32, Error> {
        if let Ok(metadata) = path.metadata() {
            self.reserve(MEMORY_FOR_A_BYTE * metadata.len(), name.span)?;
        }
        let bytes = read_whole(path, MAX_MESH_BYTES)
            .map_err(|error| unreadable(self.source, self.folder, name, &error))?;
        let index = self.meshes.len() as u32;
        if let Some(mesh) = self.by_bytes.find_or_add(path, &bytes, index) {
            self.budget.take_back_mesh(MEMORY_FOR_A_BYTE * bytes.len() as u64);
            if let Some(original) = self.mesh_files.iter().find(|file| file.mesh == mesh) {
                let names = (path.display(), original.path.display());
                self.left_out.push(format!("a second mesh for {}: its bytes are those of {}", names.0, names.1));
                self.mesh_files.push(MeshFile { path: path.to_owned(), ..original.clone() });
            }
            self.by_path.insert(path.to_owned(), mesh);
            return Ok(mesh);
        }
        let file = match obj::parse_plain_mesh(path, &bytes) {
            Some(file) => file,
            None => {
                self.reserve(MEMORY_FOR_AN_UNUSUAL_BYTE * bytes.len() as u64, name.span)?;
                obj::parse_any_mesh(path, &bytes)?
            }
        };
        let of_file = MEMORY_FOR_A_BYTE * bytes.len() as u64;
        self.reserve((MEMORY_FOR_A_TRIANGLE * file.counts.triangles as u64).saturating_sub(of_file), name.span)?;
        let shows_normals = self.plan.shows_normals();
        let finished = || if shows_normals { file.mesh.with_normals() } else { file.mesh };
        let (mesh, ()) = rayon::join(finished, || drop(bytes));
        self.meshes.push(mesh);
        self.remarks.warnings.extend(file.warnings);
        self.mesh_files.push(MeshFile { path: path.to_owned(), mesh: index, counts: file.counts });
        self.by_path.insert(path.to_owned(), index);
        Ok(index)
    }
}
