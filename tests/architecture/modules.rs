//! The modules of a crate, from its sources: which there are, the file of each, what they define and what they import.

use proc_macro2::TokenStream;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::{Attribute, File, Item, Meta, UseTree, Visibility};

/// Where a module stands: `["drive", "network"]` for `crate::drive::network`; the root is empty.
pub type ModulePath = Vec<String>;

/// A module.
#[derive(Default)]
pub struct Module {
    /// The file it is in, seen from the crate's folder.
    pub file: String,
    /// Its children.
    pub children: BTreeSet<String>,
    /// The names of the items it defines.
    pub items: BTreeSet<String>,
    /// The names that its `use` lines give, with what each stands for; two for one name under different conditions.
    pub names: Vec<(String, Use)>,
    /// `use path::*`.
    pub globs: Vec<Use>,
    /// Its items without their tests and children.
    pub code: Vec<Item>,
}

/// One path of a `use` line.
#[derive(Clone, Debug)]
pub struct Use {
    pub path: Vec<String>,
    /// `pub use`, `pub(crate) use` and the like: it passes a name on.
    pub is_reexport: bool,
}

/// All modules of a crate, `#[cfg(test)]` ones excepted.
pub struct Modules {
    modules: BTreeMap<ModulePath, Module>,
    files: BTreeMap<String, File>,
    base: PathBuf,
}

impl Modules {
    /// Reads the crate whose root file is `root`; `read` gives a file's text, if there is such a file.
    pub fn read(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Self {
        let folder = root.parent().expect("a root file in a folder");
        let base = folder.parent().unwrap_or(folder).to_owned();
        let mut modules = Self { modules: BTreeMap::new(), files: BTreeMap::new(), base };
        modules.add_file(Vec::new(), root, folder, read);
        modules
    }

    /// The files, each with its syntax tree.
    pub fn files(&self) -> &BTreeMap<String, File> {
        &self.files
    }

    /// The modules.
    pub fn iter(&self) -> impl Iterator<Item = (&ModulePath, &Module)> {
        self.modules.iter()
    }

    /// The module at a path.
    pub fn get(&self, path: &[String]) -> Option<&Module> {
        self.modules.get(path)
    }

    /// Takes the steps of a path that are modules, from the module `at`; gives the last one, and the steps that are left.
    pub fn walk<'a>(&self, at: &ModulePath, path: &'a [String]) -> (ModulePath, &'a [String]) {
        let mut module = at.clone();
        for (taken, step) in path.iter().enumerate() {
            match step.as_str() {
                "crate" => module.clear(),
                "self" => {}
                "super" => drop(module.pop()),
                name if self.get(&module).is_some_and(|module| module.children.contains(name)) => {
                    module.push(name.to_owned());
                }
                _ => return (module, &path[taken..]),
            }
        }
        (module, &[])
    }

    /// True unless the module has the name for itself and its descendants only.
    pub fn gives(&self, module: &ModulePath, name: &str, to: &ModulePath) -> bool {
        let mut lines = self.modules[module].names_called(name).peekable();
        lines.peek().is_none() || to.starts_with(module) || lines.any(|line| line.is_reexport)
    }

    /// `children_in` is the folder in which the files of the module's children lie.
    fn add_file(&mut self, path: ModulePath, file: &Path, children_in: &Path, read: &dyn Fn(&Path) -> Option<String>) {
        let text = read(file).unwrap_or_else(|| panic!("{}: no such file", file.display()));
        let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let name = file.strip_prefix(&self.base).unwrap_or(file).display().to_string();
        self.files.insert(name.clone(), syntax.clone());
        self.add(path, &name, children_in, syntax.items, read);
    }

    fn add(
        &mut self,
        path: ModulePath,
        file: &str,
        children_in: &Path,
        items: Vec<Item>,
        read: &dyn Fn(&Path) -> Option<String>,
    ) {
        let mut module = Module { file: file.to_owned(), ..Module::default() };
        for item in items {
            if is_test(attributes_of(&item)) {
                continue;
            }
            match item {
                Item::Mod(child) => {
                    let name = child.ident.to_string();
                    let path: ModulePath = path.iter().cloned().chain([name.clone()]).collect();
                    let folder = children_in.join(&name);
                    match child.content {
                        Some((_, items)) => self.add(path, file, &folder, items, read),
                        None => {
                            let beside = children_in.join(format!("{name}.rs"));
                            let within = folder.join("mod.rs");
                            let file = if read(&beside).is_some() { beside } else { within };
                            self.add_file(path, &file, &folder, read);
                        }
                    }
                    module.children.insert(name);
                }
                Item::Use(line) if line.leading_colon.is_some() => {} // another crate, for certain
                Item::Use(line) => {
                    let is_reexport = !matches!(line.vis, Visibility::Inherited);
                    module.add_use(&line.tree, Vec::new(), is_reexport);
                }
                other => {
                    module.items.extend(name_of(&other));
                    module.code.push(other);
                }
            }
        }
        self.modules.insert(path, module);
    }
}

impl Module {
    /// What the `use` lines that give `name` stand for.
    pub fn names_called<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Use> {
        self.names.iter().filter(move |(called, _)| called == name).map(|(_, line)| line)
    }

    fn add_use(&mut self, tree: &UseTree, mut prefix: Vec<String>, is_reexport: bool) {
        match tree {
            UseTree::Path(step) => {
                prefix.push(step.ident.to_string());
                self.add_use(&step.tree, prefix, is_reexport);
            }
            UseTree::Group(group) => {
                group.items.iter().for_each(|item| self.add_use(item, prefix.clone(), is_reexport));
            }
            UseTree::Glob(_) => self.globs.push(Use { path: prefix, is_reexport }),
            UseTree::Name(name) => {
                // `use a::b::{self, c}`
                let name = if name.ident == "self" { prefix.pop().unwrap_or_default() } else { name.ident.to_string() };
                prefix.push(name.clone());
                self.names.push((name, Use { path: prefix, is_reexport }));
            }
            UseTree::Rename(rename) => {
                if rename.ident != "self" {
                    prefix.push(rename.ident.to_string());
                }
                let name = match rename.rename.to_string() {
                    // `use Trait as _` gives no name; it is kept apart from others.
                    anonymous if anonymous == "_" => format!("_ {}", prefix.join("::")),
                    name => name,
                };
                self.names.push((name, Use { path: prefix, is_reexport }));
            }
        }
    }
}

/// `#[test]`, and `#[cfg(test)]` in any combination but `not(test)`.
pub fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("cfg") => names_test(&list.tokens),
        _ => false,
    })
}

fn names_test(condition: &TokenStream) -> bool {
    let words: String = condition.to_string().split_whitespace().collect();
    words
        .replace("not(test)", "")
        .split(|letter: char| !letter.is_alphanumeric() && letter != '_' && letter != '"')
        .any(|word| word == "test")
}

/// The attributes of an item.
pub fn attributes_of(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}
