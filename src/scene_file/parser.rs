//! Parses the file as a whole and the tree of objects; the other blocks are parsed by [`blocks`] and [`lights`].
//!
//! After a mistake parsing goes on where that is possible, so that a user sees up to [`MOST_SHOWN`](crate::error::MOST_SHOWN)
//! of them at once. Material indices are checked here, after the whole text is parsed. Mistakes that need arithmetic or
//! other files (a singular matrix, a missing mesh) are found by [`compile`](crate::scene::compile).

use super::description::{At, BackgroundBlock, CameraBlock, Description, Leaf, Node};
use super::fields::{Count, Fields};
use super::lexer::Token;
use super::shapes::shape_parser;
use super::transforms::{STEP_NAMES, transform_step};
use super::words::{BLOCKS, GROUP_WORDS, belongs_into, is_object, object_names};
use super::{blocks, lights};
use crate::error::{Error, SourceText, cut_short};
use std::sync::Arc;

/// Largest depth of nested groups and transforms. There must be a limit because the parser is recursive.
const MAX_NESTING: usize = 256;

/// What a scene file says, as far as it makes sense.
#[derive(Debug)]
pub struct Parsed {
    /// With mistakes, without the objects and the camera that these are about.
    pub description: Description,
    pub mistakes: Vec<Error>,
}

impl Parsed {
    /// Returns the scene if it has no mistakes.
    ///
    /// # Errors
    /// [`Error::Source`] for one mistake, [`Error::Several`] for more.
    pub fn whole(self) -> Result<Description, Error> {
        if self.mistakes.is_empty() { Ok(self.description) } else { Err(Error::all(self.mistakes)) }
    }
}

/// Parses the text of a scene file.
pub fn parse(source: SourceText) -> Parsed {
    let source = Arc::new(source);
    let mut parser = Parser { fields: Fields::new(&source), material: None, material_uses: Vec::new(), depth: 0 };
    let mut description = Description {
        camera: CameraBlock::default(),
        root: Node::Group(Vec::new()),
        source: Arc::clone(&source),
        lights: Vec::new(),
        background: BackgroundBlock::default(),
        materials: Vec::new(),
        hints: Vec::new(),
    };
    let last = parser.file(&mut description).err();
    description.hints.extend(parser.fields.foreign_space());
    let mistakes = parser.fields.mistakes.into_iter().chain(last).collect();
    Parsed { description, mistakes }
}

struct Parser<'a> {
    fields: Fields<'a>,
    /// The last `MaterialIndex`.
    material: Option<u32>,
    material_uses: Vec<At<u32>>,
    depth: usize,
}

impl<'a> Parser<'a> {
    /// Parses `PerspectiveCamera { } Lights { } Background { } Materials { } Group { }`, in any order, each at most
    /// once. Camera and group are required.
    ///
    /// # Errors
    /// [`Error::Source`] for a mistake after which nothing can be said about the rest.
    fn file(&mut self, description: &mut Description) -> Result<(), Error> {
        const REQUIRED: [&str; 2] = ["PerspectiveCamera", "Group"];
        let mut seen = Vec::new();
        let mut is_clear = true;
        while let Some(name) = self.fields.lexer.next() {
            let Some(block) = BLOCKS.into_iter().find(|block| *block == name.text) else {
                is_clear = false;
                self.unknown_block(name)?;
                continue;
            };
            let is_first = self.fields.refuse_repetition(&mut seen, block, name.span);
            if let Err(error) = is_first.and_then(|()| self.block(name, description)) {
                self.fields.go_on_after(error, "", &|word| BLOCKS.contains(&word))?;
            }
        }
        let is_missing = |block: &str| is_clear && !seen.iter().any(|seen| seen.0 == block);
        for block in REQUIRED.into_iter().filter(|block| is_missing(block)) {
            let message = format!("the scene has no '{block}' block");
            self.fields.note(self.fields.error(self.fields.lexer.end(), message))?;
        }
        self.check_material_indices(description.materials.len())
    }

    fn block(&mut self, name: Token<'a>, description: &mut Description) -> Result<(), Error> {
        let fields = &mut self.fields;
        match name.text {
            "PerspectiveCamera" => description.camera = blocks::camera(fields, name)?,
            "Lights" => description.lights = lights::lights(fields, name)?,
            "Background" => description.background = blocks::background(fields, name)?,
            "Materials" => description.materials = blocks::materials(fields, name)?,
            _ => description.root = self.group(name)?,
        }
        Ok(())
    }

    /// Notes the mistake that a word outside of all blocks is.
    fn unknown_block(&mut self, name: Token<'a>) -> Result<(), Error> {
        if name.text == "}" {
            let message = "'}' does not belong here: no block is open";
            return self.fields.note(self.fields.error(name.span, message));
        }
        if ["Lights", "Materials", "Group", "Transform"].iter().any(|block| belongs_into(block, name.text)) {
            let message =
                format!("'{}' stands outside of every block: is there a '}}' too many before it?", name.text);
            let error = self.fields.error(name.span, message);
            return Err(self.fields.lost(error));
        }
        let error = self.fields.unknown_word(name, "the top level of a scene", BLOCKS.into_iter());
        self.fields.go_on_after(error, name.text, &|word| BLOCKS.contains(&word))
    }

    /// Notes the material indices that no material has; not after other mistakes, which may be about the materials.
    fn check_material_indices(&mut self, count: usize) -> Result<(), Error> {
        let known = match count {
            0 => "the scene has no materials".to_owned(),
            1 => "the scene has one material, number 0".to_owned(),
            _ => format!("the scene's {count} materials are numbered from 0 to {}", count - 1),
        };
        if !self.fields.mistakes.is_empty() {
            return Ok(());
        }
        let wrong: Vec<_> = self.material_uses.iter().filter(|used| used.value as usize >= count).collect();
        for (index, used) in wrong.iter().enumerate() {
            if !wrong[..index].iter().any(|before| before.value == used.value) {
                let message = format!("MaterialIndex {}: {known}", used.value);
                self.fields.note(self.fields.error(used.span, message))?;
            }
        }
        Ok(())
    }

    /// Parses `Group { numObjects n  objects, with MaterialIndex i between them }`.
    fn group(&mut self, name: Token<'a>) -> Result<Node, Error> {
        let mut count = Count::new(&self.fields);
        self.fields.open_brace(name)?;
        let mut seen = Vec::new();
        let mut members = Vec::new();
        let known = |word: &str| belongs_into("Group", word);
        loop {
            let token = self.fields.next_in_block()?;
            let mut wrong = "";
            let read = match token.text {
                "}" => break,
                "numObjects" => self
                    .fields
                    .refuse_repetition(&mut seen, "numObjects", token.span)
                    .and_then(|()| count.read(&mut self.fields, token.text, token.span)),
                "MaterialIndex" => self.material_index(token),
                text if is_object(text) => self.object(token).map(|object| members.push(object)),
                _ if self.fields.ends_before(token, &known)? => break,
                _ => {
                    let known = GROUP_WORDS.into_iter().chain(object_names());
                    wrong = token.text;
                    Err(self.fields.unknown_word(token, "'Group'", known))
                }
            };
            if let Err(error) = read {
                self.fields.go_on_after(error, wrong, &known)?;
            }
        }
        self.fields.close();
        if seen.is_empty() && count.is_clear(&self.fields) {
            self.fields.note(self.fields.error(name.span, "this 'Group' has no 'numObjects'"))?;
        }
        count.check(&mut self.fields, "numObjects", members.len(), "object")?;
        Ok(Node::Group(members))
    }

    fn material_index(&mut self, token: Token<'a>) -> Result<(), Error> {
        // What is wrong with this one is not wrong with the objects behind it.
        self.material.get_or_insert(0);
        let value = self.fields.count(token.text)?;
        self.material = Some(value);
        self.material_uses.push(At { value, span: token.span });
        Ok(())
    }

    /// Parses a shape, a `Group` or a `Transform`.
    fn object(&mut self, name: Token<'a>) -> Result<Node, Error> {
        if self.depth == MAX_NESTING {
            let message = format!("objects are nested more than {MAX_NESTING} deep");
            let error = self.fields.error(name.span, message);
            return Err(self.fields.lost(error));
        }
        self.depth += 1;
        let node = match shape_parser(name.text) {
            None if name.text == "Group" => self.group(name),
            None => self.transform(name),
            Some(parse_shape) => {
                let shape = parse_shape(&mut self.fields, name);
                shape.and_then(|shape| {
                    let material = self.material_of(name)?;
                    Ok(Node::Leaf(Leaf { shape, span: name.span, material }))
                })
            }
        };
        self.depth -= 1;
        node
    }

    /// Returns the material of an object. That none stands before it is said once.
    fn material_of(&mut self, name: Token<'a>) -> Result<u32, Error> {
        if self.material.is_none() {
            let message = format!("no 'MaterialIndex' stands before this '{}'", name.text);
            self.fields.note(self.fields.error(name.span, message))?;
        }
        Ok(*self.material.get_or_insert(0))
    }

    /// Parses `Transform { transformations object }`. With a mistake, it is an empty group.
    fn transform(&mut self, name: Token<'a>) -> Result<Node, Error> {
        let mistakes = self.fields.mistakes.len();
        self.fields.open_brace(name)?;
        let mut steps = Vec::new();
        let mut child = None;
        let known = |word: &str| belongs_into("Transform", word);
        loop {
            let token = self.fields.next_in_block()?;
            let mut wrong = "";
            let read = match token.text {
                "}" => break,
                _ if child.is_some() => Err(self.after_object(name, token)),
                text if is_object(text) => self.object(token).map(|object| child = Some(Box::new(object))),
                text if STEP_NAMES.contains(&text) => {
                    transform_step(&mut self.fields, token).map(|value| steps.push(At { value, span: token.span }))
                }
                _ if self.fields.ends_before(token, &known)? => break,
                text => {
                    wrong = text;
                    Err(self.unexpected_in_transform(token))
                }
            };
            if let Err(error) = read {
                self.fields.go_on_after(error, wrong, &known)?;
            }
        }
        self.fields.close();
        match child {
            Some(child) => {
                steps.shrink_to_fit();
                Ok(Node::Transform { steps, child })
            }
            None => {
                if self.fields.mistakes.len() == mistakes {
                    self.fields.note(self.fields.error(name.span, "this 'Transform' has no object"))?;
                }
                Ok(Node::Group(Vec::new()))
            }
        }
    }

    /// Makes the error for what stands behind the object of a transform. Where that is another object, either a brace is
    /// missing before it, or a group around both: what follows means something else in each case.
    fn after_object(&mut self, name: Token<'a>, token: Token<'a>) -> Error {
        let (at, found) = (token.span.start, cut_short(token.text));
        if self.fields.unended(at) != Some(name) || self.fields.is_outside(at, name) {
            let message = format!("expected {}, found '{found}'", self.fields.missing_brace(at));
            let error = self.fields.error(token.span, message);
            return self.fields.lost(error);
        }
        let message = format!("expected '}}' after the object of {}, found '{found}'", self.fields.named(name));
        let note = "a transform holds its transformations, then one object; put several objects into a 'Group'";
        let error = self.fields.error(token.span, message).with_note(note);
        if STEP_NAMES.contains(&token.text) { error } else { self.fields.lost(error) }
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
