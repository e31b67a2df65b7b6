//! Which file of a crate imports from which: by its `use` lines, and by the paths in its code.
//!
//! A path is followed to the file that defines the name, through every file that passes it on. A file that only passes a
//! name on (`pub use child::Name`) does not import it; one that also uses the name does.

use super::modules::{Module, ModulePath, Modules};
use proc_macro2::{TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use syn::Item;
use syn::visit::{self, Visit};

/// One file uses another.
pub struct Import {
    pub from: String,
    pub to: String,
    /// The path that says so.
    pub path: String,
}

/// All imports between the files of a crate, one for each pair of files.
pub struct Imports(Vec<Import>);

impl Imports {
    /// Finds them.
    pub fn of(modules: &Modules) -> Self {
        let mut found: BTreeMap<(String, String), String> = BTreeMap::new();
        for (at, module) in modules.iter() {
            for path in paths_of(module) {
                for to in files_behind(modules, at, &path) {
                    if to != module.file {
                        found.entry((module.file.clone(), to)).or_insert_with(|| path.join("::"));
                    }
                }
            }
        }
        Self(found.into_iter().map(|((from, to), path)| Import { from, to, path }).collect())
    }

    pub fn iter(&self) -> impl Iterator<Item = &Import> {
        self.0.iter()
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }
}

/// Every path that a module uses: those of its `use` lines first, since they say most.
fn paths_of(module: &Module) -> Vec<Vec<String>> {
    let imported = module.names.iter().map(|(_, line)| line).chain(&module.globs).filter(|line| !line.is_reexport);
    let mut paths: Vec<_> = imported.map(|line| line.path.clone()).collect();
    let mut code = Paths::default();
    module.code.iter().for_each(|item| code.visit_item(item));
    // A variable may have the name of a child.
    let is_variable =
        |name: &String| module.children.contains(name) || matches!(name.as_str(), "crate" | "self" | "super");
    paths.extend(code.0.into_iter().filter(|path| path.len() > 1 || !path.iter().any(is_variable)));
    paths
}

/// Collects the paths in items; those in macro calls too.
#[derive(Default)]
struct Paths(BTreeSet<Vec<String>>);

impl<'ast> Visit<'ast> for Paths {
    fn visit_item(&mut self, item: &'ast Item) {
        if !super::modules::is_test(super::modules::attributes_of(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if !super::modules::is_test(&function.attrs) {
            visit::visit_impl_item_fn(self, function);
        }
    }

    /// `pub(super)` uses nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.leading_colon.is_none() {
            self.0.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    /// In a function; those of the module itself are taken apart elsewhere.
    fn visit_item_use(&mut self, line: &'ast syn::ItemUse) {
        let text: TokenStream = line.tree.to_token_stream();
        self.add_tree(text, &[]);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.visit_path(&call.path);
        self.add_tokens(call.tokens.clone());
    }
}

impl Paths {
    /// `a::{b, c::*}`
    fn add_tree(&mut self, tokens: TokenStream, prefix: &[String]) {
        let mut path = prefix.to_vec();
        for token in tokens {
            match token {
                TokenTree::Ident(word) if word != "as" => path.push(word.to_string()),
                TokenTree::Punct(mark) if mark.as_char() == ',' => {
                    self.0.insert(std::mem::replace(&mut path, prefix.to_vec()));
                }
                TokenTree::Group(group) => {
                    self.add_tree(group.stream(), &path);
                    path = prefix.to_vec();
                }
                _ => {}
            }
        }
        if path.len() > prefix.len() {
            self.0.insert(path);
        }
    }

    /// Words with `::` between them.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(word) => {
                    if colons != 2 {
                        self.take(&mut path);
                    }
                    path.push(word.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                other => {
                    self.take(&mut path);
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.add_tokens(group.stream());
                    }
                }
            }
        }
        self.take(&mut path);
    }

    fn take(&mut self, path: &mut Vec<String>) {
        let path = std::mem::take(path);
        if !path.is_empty() {
            self.0.insert(path);
        }
    }
}

/// No path of a crate has as many steps.
const LONGEST_PATH: usize = 16;

/// The files that a path depends on, seen from the module `at`: the one that holds the name, and those behind it if it only
/// passes the name on. None for a path into another crate.
fn files_behind(modules: &Modules, at: &ModulePath, path: &[String]) -> BTreeSet<String> {
    let mut search = Search { modules, seen: BTreeSet::new(), files: BTreeSet::new() };
    search.follow(at, path);
    search.files
}

struct Search<'a> {
    modules: &'a Modules,
    seen: BTreeSet<(ModulePath, Vec<String>)>,
    files: BTreeSet<String>,
}

impl Search<'_> {
    /// True if the path names something of this crate.
    fn follow(&mut self, at: &ModulePath, path: &[String]) -> bool {
        // Modules may pass each other's names on, and `use name::name` makes a path longer each time.
        if path.len() > LONGEST_PATH || !self.seen.insert((at.clone(), path.to_vec())) {
            return false;
        }
        let (found_in, rest) = self.modules.walk(at, path);
        let Some(module) = self.modules.get(&found_in) else { return false };
        let is_named = match rest.split_first() {
            None => true,
            Some((name, rest)) => self.look_up(&found_in, module, name, rest),
        };
        let is_own = rest.len() < path.len();
        if is_named || is_own {
            self.files.insert(module.file.clone());
        }
        is_named
    }

    /// True if the module has something of this name.
    fn look_up(&mut self, at: &ModulePath, module: &Module, name: &String, rest: &[String]) -> bool {
        let mut is_named = module.items.contains(name);
        for line in module.names_called(name) {
            let longer: Vec<String> = line.path.iter().chain(rest).cloned().collect();
            self.follow(at, &longer);
            is_named = true;
        }
        if !is_named {
            let longer: Vec<String> = [name].into_iter().chain(rest).cloned().collect();
            // Each of them may be the one that gives the name.
            for line in &module.globs {
                let (target, left) = self.modules.walk(at, &line.path);
                is_named |= left.is_empty() && self.modules.gives(&target, name, at) && self.follow(&target, &longer);
            }
        }
        is_named
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycles;
    use std::path::Path;

    /// The cycles of a crate of these files, each as its files in order.
    fn cycles_of(files: &[(&str, &str)]) -> Vec<String> {
        let read = |path: &Path| {
            let name = path.to_str().unwrap();
            files.iter().find(|(file, _)| *file == name).map(|(_, text)| (*text).to_owned())
        };
        let imports = Imports::of(&Modules::read(Path::new("src/lib.rs"), &read));
        let cycles = cycles::shortest(&imports);
        cycles.iter().map(|cycle| cycle.iter().map(|step| step.from.as_str()).collect::<Vec<_>>().join(" ")).collect()
    }

    const ROOT: (&str, &str) = ("src/lib.rs", "mod a; mod b;");

    #[test]
    fn files_that_import_one_way_are_fine() {
        let b =
            ("src/b.rs", "pub struct B; #[cfg(test)] mod tests { use crate::a::A; } #[test] fn t() { crate::a::f(); }");
        assert_eq!(cycles_of(&[ROOT, ("src/a.rs", "use crate::b::B; pub struct A;"), b]), [""; 0]);
    }

    #[test]
    fn two_files_that_import_each_other_are_found_however_it_is_written() {
        for import in [
            "use crate::a::A;",
            "use crate::{a::{A}};",
            "use super::a::A;",
            "use super::a;",
            "use super::{a as other};",
            "use super::a::*;",
            "use crate::a::Trait as _;",
            "fn f() { crate::a::f(); }",
            "fn f() { use crate::{a::f, c}; }",
            "fn f(a: super::a::A) {}",
            "fn f() { println!(\"{}\", crate::a::f(1)); }",
            "mod inner { fn f() { super::super::a::f() } }",
            "impl crate::a::A {}",
            "pub use crate::a::A; fn f(a: A) {}",
            "#[cfg(not(test))] fn f() { crate::a::f() }",
        ] {
            let found = cycles_of(&[ROOT, ("src/a.rs", "use crate::b::B; pub struct A;"), ("src/b.rs", import)]);
            assert_eq!(found, ["src/a.rs src/b.rs"], "{import}");
        }
    }

    #[test]
    fn a_parent_that_passes_names_on_is_no_part_of_a_circle() {
        let parent = ("src/a/mod.rs", "mod one; mod two; pub use one::One; pub(crate) use two::*;");
        let two = ("src/a/two.rs", "use super::One; pub struct Two;");
        let files = [("src/lib.rs", "mod a;"), parent, ("src/a/one.rs", "pub struct One;"), two];
        assert_eq!(cycles_of(&files), [""; 0]);
    }

    #[test]
    fn a_sibling_is_no_import_of_the_parent() {
        let two = ("src/a/two.rs", "use super::one::One; use crate::a::one; fn f() { one::f(); crate::a::one::g() }");
        let files = [
            ("src/lib.rs", "mod a;"),
            ("src/a.rs", "mod one; mod two; use two::f;"),
            ("src/a/one.rs", "pub struct One;"),
        ];
        assert_eq!(cycles_of(&[files[0], files[1], files[2], two]), [""; 0]);
    }

    #[test]
    fn a_child_that_uses_what_its_parent_defines_or_uses_is_found() {
        let child = ("src/a/one.rs", "use super::Shared; pub struct One;");
        for parent in ["mod one; use one::One; struct Shared;", "mod one; pub use one::One; struct Shared(One);"] {
            let found = cycles_of(&[("src/lib.rs", "mod a;"), ("src/a.rs", parent), child]);
            assert_eq!(found, ["src/a.rs src/a/one.rs"], "{parent}");
        }
    }

    #[test]
    fn names_that_are_passed_on_are_followed_to_their_file() {
        for root in ["mod a; mod b; pub use a::A; pub use b::B;", "mod a; mod b; pub use a::*; pub use b::*;"] {
            let files = [("src/lib.rs", root), ("src/a.rs", "use crate::B; pub struct A;")];
            let found = cycles_of(&[files[0], files[1], ("src/b.rs", "use crate::A; pub struct B;")]);
            assert_eq!(found, ["src/a.rs src/b.rs"], "{root}");
        }
    }

    #[test]
    fn a_circle_of_three_is_found_once() {
        let root = ("src/lib.rs", "mod a; mod b; mod c;");
        let files = [
            root,
            ("src/a.rs", "use crate::b::B;"),
            ("src/b.rs", "use crate::c::C;"),
            ("src/c.rs", "use crate::a::A;"),
        ];
        assert_eq!(cycles_of(&files), ["src/a.rs src/b.rs src/c.rs"]);
    }

    #[test]
    fn a_variable_with_the_name_of_a_child_is_no_import() {
        let child = ("src/a/one.rs", "use super::Shared; pub(super) struct One;");
        let parent = "mod one; pub struct Shared; fn f(one: u8) -> u8 { println!(\"{}\", one); one }";
        assert_eq!(cycles_of(&[("src/lib.rs", "mod a;"), ("src/a.rs", parent), child]), [""; 0]);
    }

    #[test]
    fn other_crates_are_not_followed() {
        let b = (
            "src/b.rs",
            "use a_crate::a::A; use ::a::B; use toml::toml; fn f() -> std::io::Result<()> { anyhow::bail!(\"no\") }",
        );
        assert_eq!(cycles_of(&[ROOT, ("src/a.rs", "use crate::b::B;"), b]), [""; 0]);
    }
}
