//! Parses the file as a whole and the tree of objects; the other blocks are parsed by [`blocks`] and [`lights`].
//!
//! Material indices are checked here, after the whole text is parsed. Mistakes that need arithmetic or other files (a
//! singular matrix, a missing mesh) are found by [`compile`](crate::scene::compile).

use super::description::{At, BackgroundBlock, Description, Leaf, Node};
use super::fields::{Count, Fields};
use super::lexer::Token;
use super::shapes::{shape_names, shape_parser};
use super::transforms::{STEP_NAMES, transform_step};
use super::{blocks, lights};
use crate::error::{Error, SourceText, cut_short};
use crate::input::read_whole;
use std::path::Path;
use std::sync::Arc;

/// Largest depth of nested groups and transforms. There must be a limit because the parser is recursive.
const MAX_NESTING: usize = 256;
/// Largest scene file that is read.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Reads and parses the scene file at `path`.
///
/// # Errors
/// [`Error::File`] when the file cannot be read or is not UTF-8, [`Error::Source`] for a mistake in it.
pub fn parse_file(path: &Path) -> Result<Description, Error> {
    let cannot_read = |error| Error::io(path, "read the scene", &error);
    let metadata = std::fs::metadata(path).map_err(cannot_read)?;
    if metadata.is_dir() {
        return Err(Error::file(path, "this is a folder, not a scene file"));
    }
    let bytes = read_whole(path, MAX_FILE_BYTES).map_err(cannot_read)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let line = error.as_bytes()[..error.utf8_error().valid_up_to()].split(|&b| b == b'\n').count();
        Error::file(path, format!("line {line} is not UTF-8 text: save the file as UTF-8"))
    })?;
    parse(SourceText { path: path.to_owned(), text })
}

/// Parses the text of a scene file.
///
/// # Errors
/// [`Error::Source`] for the first mistake in the text.
pub fn parse(source: SourceText) -> Result<Description, Error> {
    let source = Arc::new(source);
    let mut parser = Parser { fields: Fields::new(&source), material: None, material_uses: Vec::new(), depth: 0 };
    parser.file()
}

struct Parser<'a> {
    fields: Fields<'a>,
    /// The last `MaterialIndex`.
    material: Option<u32>,
    material_uses: Vec<At<u32>>,
    depth: usize,
}

/// Objects that contain other objects.
const CONTAINERS: [&str; 2] = ["Group", "Transform"];

fn object_names() -> impl Iterator<Item = &'static str> + Clone {
    shape_names().chain(CONTAINERS)
}

fn is_object(word: &str) -> bool {
    object_names().any(|name| name == word)
}

impl<'a> Parser<'a> {
    /// Parses `PerspectiveCamera { } Lights { } Background { } Materials { } Group { }`, in any order, each at most
    /// once. Camera and group are required.
    fn file(&mut self) -> Result<Description, Error> {
        const BLOCKS: [&str; 5] = ["PerspectiveCamera", "Lights", "Background", "Materials", "Group"];
        let (mut camera, mut lights, mut materials, mut root) = (None, Vec::new(), Vec::new(), None);
        let mut background = BackgroundBlock::default();
        let mut seen = Vec::new();
        while let Some(name) = self.fields.lexer.next() {
            let Some(block) = BLOCKS.into_iter().find(|block| *block == name.text) else {
                return Err(self.fields.unknown_word(name, "the top level of a scene", BLOCKS.into_iter()));
            };
            self.fields.refuse_repetition(&mut seen, block, name.span)?;
            match block {
                "PerspectiveCamera" => camera = Some(blocks::camera(&mut self.fields, name)?),
                "Lights" => lights = lights::lights(&mut self.fields, name)?,
                "Background" => background = blocks::background(&mut self.fields, name)?,
                "Materials" => materials = blocks::materials(&mut self.fields, name)?,
                _ => root = Some(self.group(name)?),
            }
        }
        let missing =
            |block: &str| self.fields.error(self.fields.lexer.end(), format!("the scene has no '{block}' block"));
        let description = Description {
            camera: camera.ok_or_else(|| missing("PerspectiveCamera"))?,
            root: root.ok_or_else(|| missing("Group"))?,
            source: Arc::clone(self.fields.source),
            lights,
            background,
            materials,
        };
        self.check_material_indices(description.materials.len())?;
        Ok(description)
    }

    fn check_material_indices(&self, count: usize) -> Result<(), Error> {
        match self.material_uses.iter().find(|used| used.value as usize >= count) {
            None => Ok(()),
            Some(used) => {
                let known = match count {
                    0 => "the scene has no materials".to_owned(),
                    1 => "the scene has one material, number 0".to_owned(),
                    _ => format!("the scene's {count} materials are numbered from 0 to {}", count - 1),
                };
                let message = format!("MaterialIndex {}: {known}", used.value);
                Err(self.fields.error(used.span, message))
            }
        }
    }

    /// Parses `Group { numObjects n  objects, with MaterialIndex i between them }`.
    fn group(&mut self, name: Token<'a>) -> Result<Node, Error> {
        let fields = &mut self.fields;
        fields.open_brace(name.text)?;
        let mut count = Count::default();
        let mut seen = Vec::new();
        let mut members = Vec::new();
        loop {
            let token =
                self.fields.next(|fields| format!("'}}' to end 'Group' of line {}", fields.line(name.span)))?;
            match token.text {
                "}" => break,
                "numObjects" => {
                    self.fields.refuse_repetition(&mut seen, "numObjects", token.span)?;
                    count.read(&mut self.fields, token.text, token.span)?;
                }
                "MaterialIndex" => {
                    let value = self.fields.count(token.text)?;
                    self.material = Some(value);
                    self.material_uses.push(At { value, span: token.span });
                }
                text if is_object(text) => members.push(self.object(token)?),
                _ => {
                    let known = ["numObjects", "MaterialIndex"].into_iter().chain(object_names());
                    return Err(self.fields.unknown_word(token, "'Group'", known));
                }
            }
        }
        if seen.is_empty() {
            return Err(self.fields.error(name.span, "this 'Group' has no 'numObjects'"));
        }
        count.check(&self.fields, "numObjects", members.len(), "object")?;
        Ok(Node::Group(members))
    }

    /// Parses a shape, a `Group` or a `Transform`.
    fn object(&mut self, name: Token<'a>) -> Result<Node, Error> {
        self.depth += 1;
        if self.depth > MAX_NESTING {
            let message = format!("objects are nested more than {MAX_NESTING} deep");
            return Err(self.fields.error(name.span, message));
        }
        let node = match shape_parser(name.text) {
            None if name.text == "Group" => self.group(name)?,
            None => self.transform(name)?,
            Some(parse_shape) => {
                let shape = parse_shape(&mut self.fields, name)?;
                let Some(material) = self.material else {
                    let message = format!("no 'MaterialIndex' stands before this '{}'", name.text);
                    return Err(self.fields.error(name.span, message));
                };
                Node::Leaf(Leaf { shape, span: name.span, material })
            }
        };
        self.depth -= 1;
        Ok(node)
    }

    /// Parses `Transform { transformations object }`.
    fn transform(&mut self, name: Token<'a>) -> Result<Node, Error> {
        self.fields.open_brace(name.text)?;
        let mut steps = Vec::new();
        let child = loop {
            let token = self.fields.next(|_| "a transformation or an object".to_owned())?;
            if is_object(token.text) {
                break Box::new(self.object(token)?);
            }
            if token.text == "}" {
                return Err(self.fields.error(name.span, "this 'Transform' has no object"));
            }
            if !STEP_NAMES.contains(&token.text) {
                return Err(self.unexpected_in_transform(token));
            }
            steps.push(At { value: transform_step(&mut self.fields, token)?, span: token.span });
        };
        let token = self.fields.next(|_| "'}' to end 'Transform'".to_owned())?;
        if token.text == "}" {
            steps.shrink_to_fit();
            return Ok(Node::Transform { steps, child });
        }
        let message =
            format!("expected '}}' after the object of this 'Transform', found '{}'", cut_short(token.text));
        let note = "a transform holds its transformations, then one object; put several objects into a 'Group'";
        Err(self.fields.error(token.span, message).with_note(note))
    }

    fn unexpected_in_transform(&self, token: Token<'a>) -> Error {
        if token.text == "MaterialIndex" {
            let message = "'MaterialIndex' stands in a 'Group', not in a 'Transform'";
            return self.fields.error(token.span, message);
        }
        let known = STEP_NAMES.into_iter().chain(object_names());
        self.fields.unknown_word(token, "'Transform'", known)
    }
}
