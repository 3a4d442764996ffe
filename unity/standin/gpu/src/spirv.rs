//! SPIR-V as an engine sees a shader: what it binds, by name. What DXC makes of HLSL names variables as HLSL does.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;

/// What a variable is bound with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A constant buffer.
    Constant,
    /// A buffer of bytes or structures.
    Buffer {
        writable: bool,
    },
    /// A texture that is sampled or loaded from.
    Texture(Shape),
    /// A texture that is written, perhaps read too.
    Image(Shape),
    Sampler,
}

/// The form of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    Flat,
    Array,
    Cube,
    Solid,
}

/// A variable that wants a resource.
#[derive(Clone, Debug)]
pub struct Variable {
    pub name: String,
    /// Its place among this module's bindings, counted without gaps.
    pub binding: u32,
    pub kind: Kind,
    /// What HLSL declared a buffer as: `raw`, `structured`, or `any` where the compiler does not say.
    pub access: &'static str,
    /// Bytes of a constant buffer.
    pub size: u32,
    /// Name, offset and size in bytes of what a constant buffer holds.
    pub members: Vec<(String, u32, u32)>,
}

/// A module, ready for a device, and what it binds.
#[derive(Clone, Debug)]
pub struct Module {
    pub words: Vec<u32>,
    pub entry: String,
    pub variables: Vec<Variable>,
    pub threads: [u32; 3],
    /// Whether its constant buffers are bound as storage: see [`Module::put_constants_into_storage`].
    pub constants_in_storage: bool,
}

#[derive(Clone, Debug)]
enum Type {
    Scalar(u32),
    Vector(u32, u32),
    Matrix(u32, u32),
    Array(u32, u32),
    RuntimeArray,
    Struct(Vec<u32>),
    Image { dimension: u32, arrayed: bool, sampled: u32 },
    Sampler,
    Pointer(u32),
}

/// Where an instruction starts, its opcode and its operands.
type Instruction<'a> = (usize, u32, &'a [u32]);

/// The instructions after the header.
fn instructions(words: &[u32]) -> Result<Vec<Instruction<'_>>, String> {
    let mut found = Vec::new();
    let mut at = 5;
    while at < words.len() {
        let length = (words[at] >> 16) as usize;
        let operands =
            words.get(at + 1..at + length).ok_or("the SPIR-V ends in the middle of an instruction")?;
        if length == 0 {
            return Err("the SPIR-V has an instruction of no length".into());
        }
        found.push((at, words[at] & 0xffff, operands));
        at += length;
    }
    Ok(found)
}

fn text(words: &[u32]) -> String {
    let bytes: Vec<u8> =
        words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

impl Module {
    /// Reads a module, counts its bindings without gaps (wgpu does so, and optimisers leave some) and puts them into the
    /// descriptor set `set`: a pipeline's two stages keep apart that way.
    ///
    /// # Errors
    /// Text that says what the module has that no kernel of ours has.
    pub fn read(mut words: Vec<u32>, set: u32) -> Result<Self, String> {
        if words.first() != Some(&0x0723_0203) {
            return Err("this is no SPIR-V".into());
        }
        let mut bindings: Vec<(u32, u32, usize)> = Vec::new();
        let mut sets = HashMap::new();
        for (at, opcode, operands) in instructions(&words)? {
            match (opcode, operands) {
                (71, [_, 34, set]) => drop(sets.insert(operands[0], (*set, at + 3))),
                (71, [target, 33, binding]) => bindings.push((*target, *binding, at + 3)),
                _ => {}
            }
        }
        // Without optimisation a module holds what its entry point does not use, too: that comes last, and is not told of.
        let used = used_globals(&words)?;
        bindings.sort_by_key(|(target, binding, _)| {
            (!used.contains(target), sets.get(target).map_or(0, |set| set.0), *binding)
        });
        let mut numbers = HashMap::new();
        for (number, (target, _, at)) in bindings.iter().enumerate() {
            words[*at] = number as u32;
            if used.contains(target) {
                numbers.insert(*target, number as u32);
            }
        }
        for (_, at) in sets.values() {
            words[*at] = set;
        }
        formatless_images(&mut words)?;
        let mut module = Self {
            words: Vec::new(),
            entry: String::new(),
            variables: Vec::new(),
            threads: [1; 3],
            constants_in_storage: false,
        };
        module.reflect(&words, &numbers)?;
        module.words = words;
        Ok(module)
    }

    /// Makes its constant buffers storage to the driver; all else sees constant buffers as before. Mesa's driver in software
    /// takes what is in uniforms for constants: it compiles a kernel anew whenever they change, and keeps each.
    ///
    /// # Errors
    /// Text, of a module that is none.
    pub fn put_constants_into_storage(&mut self) -> Result<(), String> {
        let (mut structs, mut pointees, mut blocks) = (HashSet::<u32>::new(), HashMap::new(), Vec::new());
        for (at, opcode, operands) in instructions(&self.words)? {
            match (opcode, operands) {
                (32, [pointer, 2, pointee]) => drop(pointees.insert(*pointer, *pointee)),
                (59, [pointer, _, 2, ..]) => structs.extend(pointees.get(pointer)),
                // Block, which becomes BufferBlock.
                (71, [target, 2]) => blocks.push((*target, at + 2)),
                _ => {}
            }
        }
        for (target, at) in blocks {
            if structs.contains(&target) {
                self.words[at] = 3;
            }
        }
        self.constants_in_storage = true;
        Ok(())
    }

    fn reflect(&mut self, words: &[u32], numbers: &HashMap<u32, u32>) -> Result<(), String> {
        let (mut names, mut member_names) = (HashMap::new(), HashMap::new());
        let (mut offsets, mut strides, mut matrix_strides) = (HashMap::new(), HashMap::new(), HashMap::new());
        let (mut types, mut constants) = (HashMap::new(), HashMap::new());
        let (mut read_only, mut blocks, mut variables) = (Vec::new(), HashMap::new(), Vec::new());
        for (_, opcode, operands) in instructions(words)? {
            match (opcode, operands) {
                (5, [target, name @ ..]) => drop(names.insert(*target, text(name))),
                (6, [target, member, name @ ..]) => drop(member_names.insert((*target, *member), text(name))),
                (15, [_, _, name @ ..]) if self.entry.is_empty() => self.entry = text(name),
                (15, _) => return Err("the SPIR-V has more than one entry point".into()),
                (16, [_, 17, x, y, z]) => self.threads = [*x, *y, *z],
                (71, [target, 2, ..]) => drop(blocks.insert(*target, false)),
                (71, [target, 3, ..]) => drop(blocks.insert(*target, true)),
                (71, [target, 6, stride]) => drop(strides.insert(*target, *stride)),
                (71, [target, 24, ..]) => read_only.push(*target),
                (72, [target, member, 35, offset]) => drop(offsets.insert((*target, *member), *offset)),
                (72, [target, member, 7, stride]) => drop(matrix_strides.insert((*target, *member), *stride)),
                (72, [target, _, 24]) => read_only.push(*target),
                (20..=22, [target, width @ ..]) => {
                    drop(types.insert(*target, Type::Scalar(width.first().map_or(4, |bits| bits / 8))));
                }
                (23, [target, of, count]) => drop(types.insert(*target, Type::Vector(*of, *count))),
                (24, [target, of, count]) => drop(types.insert(*target, Type::Matrix(*of, *count))),
                (25, [target, _, dimension, _, arrayed, _, sampled, ..]) => {
                    let image =
                        Type::Image { dimension: *dimension, arrayed: *arrayed == 1, sampled: *sampled };
                    drop(types.insert(*target, image));
                }
                (26, [target]) => drop(types.insert(*target, Type::Sampler)),
                (28, [target, of, length]) => drop(types.insert(*target, Type::Array(*of, *length))),
                (29, [target, ..]) => drop(types.insert(*target, Type::RuntimeArray)),
                (30, [target, members @ ..]) => drop(types.insert(*target, Type::Struct(members.to_vec()))),
                (32, [target, _, pointee]) => drop(types.insert(*target, Type::Pointer(*pointee))),
                (43, [_, target, value, ..]) => drop(constants.insert(*target, *value)),
                (59, [pointer, target, class, ..]) => variables.push((*pointer, *target, *class)),
                _ => {}
            }
        }
        let sizes = Sizes {
            types: &types,
            constants: &constants,
            offsets: &offsets,
            strides: &strides,
            matrix_strides: &matrix_strides,
        };
        for (pointer, target, class) in variables {
            let Some(binding) = numbers.get(&target) else { continue };
            let Some(Type::Pointer(pointee)) = types.get(&pointer) else { continue };
            let name = names.get(&target).cloned().unwrap_or_default();
            let type_name = names.get(pointee).cloned().unwrap_or_default();
            let is_read_only = read_only.contains(&target) || read_only.contains(pointee);
            let kind = match (class, types.get(pointee)) {
                (2, Some(Type::Struct(_))) if blocks.get(pointee) == Some(&true) => {
                    Kind::Buffer { writable: !is_read_only }
                }
                (12, Some(Type::Struct(_))) => Kind::Buffer { writable: !is_read_only },
                (2, Some(Type::Struct(_))) => Kind::Constant,
                (0, Some(Type::Sampler)) => Kind::Sampler,
                (0, Some(Type::Image { dimension, arrayed, sampled })) => {
                    let shape = match (dimension, arrayed) {
                        (1, false) => Shape::Flat,
                        (1, true) => Shape::Array,
                        (2, _) => Shape::Solid,
                        (3, false) => Shape::Cube,
                        _ => {
                            return Err(format!(
                                "{name} is a texture of a form that the stand-in does not have"
                            ));
                        }
                    };
                    if *sampled == 2 { Kind::Image(shape) } else { Kind::Texture(shape) }
                }
                (class, other) => {
                    return Err(format!(
                        "{name} is bound as nothing that is known: class {class}, {other:?}"
                    ));
                }
            };
            let access = match () {
                () if type_name.contains("ByteAddressBuffer") => "raw",
                () if type_name.contains("StructuredBuffer") => "structured",
                () => "any",
            };
            let (mut size, mut members) = (0, Vec::new());
            if kind == Kind::Constant {
                size = sizes.of(*pointee, 0);
                if let Some(Type::Struct(fields)) = types.get(pointee) {
                    for (index, field) in fields.iter().enumerate() {
                        let key = (*pointee, index as u32);
                        let stride = matrix_strides.get(&key).copied().unwrap_or(0);
                        let member = member_names.get(&key).cloned().unwrap_or_default();
                        members.push((
                            member,
                            offsets.get(&key).copied().unwrap_or(0),
                            sizes.of(*field, stride),
                        ));
                    }
                }
            }
            self.variables.push(Variable { name, binding: *binding, kind, access, size, members });
        }
        self.variables.sort_by_key(|variable| variable.binding);
        Ok(())
    }

    /// One line each of what is bound, for the C# half: name, kind, binding, size.
    pub fn describe(&self) -> String {
        let mut text = format!(
            "entry\t{}\nthreads\t{}\t{}\t{}\n",
            self.entry, self.threads[0], self.threads[1], self.threads[2]
        );
        for variable in &self.variables {
            let kind = match variable.kind {
                Kind::Constant => "constant".to_owned(),
                Kind::Buffer { writable } => {
                    format!("{}{}", if writable { "rw" } else { "" }, variable.access)
                }
                Kind::Texture(shape) => format!("{shape:?}").to_lowercase(),
                Kind::Image(shape) => format!("rw{shape:?}").to_lowercase(),
                Kind::Sampler => "sampler".to_owned(),
            };
            let _ = writeln!(
                text,
                "variable\t{}\t{kind}\t{}\t{}",
                variable.name, variable.binding, variable.size
            );
            for (name, offset, size) in &variable.members {
                let _ = writeln!(text, "member\t{name}\t{offset}\t{size}");
            }
        }
        text
    }
}

struct Sizes<'a> {
    types: &'a HashMap<u32, Type>,
    constants: &'a HashMap<u32, u32>,
    offsets: &'a HashMap<(u32, u32), u32>,
    strides: &'a HashMap<u32, u32>,
    matrix_strides: &'a HashMap<(u32, u32), u32>,
}

impl Sizes<'_> {
    /// Bytes of a type; of a matrix with the stride that its structure gives it.
    fn of(&self, id: u32, matrix_stride: u32) -> u32 {
        match self.types.get(&id) {
            Some(Type::Scalar(size)) => *size,
            Some(Type::Vector(of, count)) => self.of(*of, 0) * count,
            Some(Type::Matrix(of, count)) => match matrix_stride {
                0 => self.of(*of, 0) * count,
                stride => stride * count,
            },
            Some(Type::Array(of, length)) => {
                let stride = self.strides.get(&id).copied().unwrap_or_else(|| self.of(*of, matrix_stride));
                stride * self.constants.get(length).copied().unwrap_or(0)
            }
            Some(Type::Struct(members)) => (0u32..)
                .zip(members)
                .map(|(index, member)| {
                    let stride = self.matrix_strides.get(&(id, index)).copied().unwrap_or(0);
                    self.offsets.get(&(id, index)).copied().unwrap_or(0) + self.of(*member, stride)
                })
                .max()
                .unwrap_or(0),
            _ => 0,
        }
    }
}

/// The module's variables that functions which the entry point calls, itself included, name.
fn used_globals(words: &[u32]) -> Result<HashSet<u32>, String> {
    let (mut globals, mut entry) = (HashSet::new(), None);
    // By function: what it names, and whom it calls.
    let mut functions: HashMap<u32, (HashSet<u32>, Vec<u32>)> = HashMap::new();
    let mut current = None;
    for (_, opcode, operands) in instructions(words)? {
        match (opcode, operands) {
            (15, [_, function, ..]) => entry = Some(*function),
            (59, [_, target, ..]) if current.is_none() => drop(globals.insert(*target)),
            (54, [_, function, ..]) => {
                current = Some(*function);
                functions.insert(*function, Default::default());
            }
            (56, _) => current = None,
            _ => {
                if let Some((names, calls)) = current.and_then(|function| functions.get_mut(&function)) {
                    if let (57, [_, _, called, ..]) = (opcode, operands) {
                        calls.push(*called);
                    }
                    // Where each instruction names pointers: its other words may be literals.
                    let pointers = match opcode {
                        57 => operands.get(3..),
                        60 | 61 | 65..=68 | 83 => operands.get(2..3),
                        62 => operands.get(..1),
                        63 | 64 => operands.get(..2),
                        _ => None,
                    };
                    names.extend(pointers.into_iter().flatten().filter(|pointer| globals.contains(pointer)));
                }
            }
        }
    }
    let (mut used, mut seen, mut next) = (HashSet::new(), HashSet::new(), Vec::from_iter(entry));
    while let Some(function) = next.pop() {
        if let (true, Some((names, calls))) = (seen.insert(function), functions.get(&function)) {
            used.extend(names);
            next.extend(calls);
        }
    }
    Ok(used)
}

/// Takes the formats off images that are written: HLSL says `float`, and the texture's own format decides.
fn formatless_images(words: &mut Vec<u32>) -> Result<(), String> {
    let images: Vec<usize> = instructions(words)?
        .iter()
        .filter(|(_, opcode, operands)| *opcode == 25 && operands.get(6) == Some(&2))
        .map(|(at, ..)| *at)
        .collect();
    if images.is_empty() {
        return Ok(());
    }
    for at in images {
        words[at + 8] = 0;
    }
    // StorageImageReadWithoutFormat, StorageImageWriteWithoutFormat.
    for capability in [55, 56] {
        let has = instructions(words)?
            .iter()
            .any(|(_, opcode, operands)| *opcode == 17 && operands == &[capability]);
        if !has {
            words.splice(5..5, [2 << 16 | 17, capability]);
        }
    }
    Ok(())
}
