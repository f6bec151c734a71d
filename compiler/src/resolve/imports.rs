//! Scopes of files: the names that a file declares or imports, from the scopes of the expansion.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use dsl::tree::{ItemKind, MissionMember, MissionRepeat, Spec, StateBody};
use dsl::{SourceId, Span, Spanned, Syntax};

use robot::Base;

use super::declare::{New, declared_levels};
use super::srdf::read_srdf;
use super::symbols::{FileId, Symbol, SymbolId, SymbolKind};
use super::urdf::Urdf;
use super::{Around, CompletionContext, File, Meaning, Offered, Resolution, Resolver, Scope};
use crate::expand::{CLASSES, Class, Module, Target, declared, read_file, read_files};
use crate::input::{Input, Texts};
use crate::robot_binding::ORIENTATION;

/// Spec that a member runs, as written.
fn spec_of(member: &MissionMember) -> Option<&str> {
    let runs = member.settings.get("runs")?.value.entries();
    runs.iter().find(|e| e.key.value == "spec")?.value.word()
}

/// Symbol whose name has this span, also in a copy that a repetition makes of its declaration; a name in quotes follows
/// the quote.
fn at(starts: &BTreeMap<usize, SymbolId>, name: Span) -> Option<SymbolId> {
    let start = name.range().start;
    starts.range(start..=start + 1).next().map(|(_, id)| *id)
}

/// Name space of a kind of declaration.
fn class_of(kind: SymbolKind) -> Option<Class> {
    match kind {
        SymbolKind::Robot => Some(Class::Robot),
        SymbolKind::Task => Some(Class::Task),
        SymbolKind::Stack => Some(Class::Stack),
        SymbolKind::Machine => Some(Class::Machine),
        SymbolKind::Mission => Some(Class::Mission),
        SymbolKind::Param
        | SymbolKind::Let
        | SymbolKind::Signal
        | SymbolKind::Variable
        | SymbolKind::Event
        | SymbolKind::Human
        | SymbolKind::SafetyField
        | SymbolKind::Obstacle => Some(Class::Value),
        _ => None,
    }
}

impl<'t> Resolver<'t> {
    pub(super) fn new(out: Resolution, input: &Input<'t>) -> Resolver<'t> {
        Resolver {
            out,
            text: input.text,
            syntax: input.syntax,
            scopes: Vec::new(),
            inside: BTreeMap::new(),
            named_files: BTreeMap::new(),
            links: None,
            joints: None,
            srdf: None,
            base_names: BTreeSet::new(),
            children: BTreeMap::new(),
            bases: BTreeMap::new(),
            controllers: BTreeMap::new(),
            bound: Vec::new(),
            holes: Vec::new(),
            around: Around::default(),
        }
    }

    pub(super) fn text_of(&self, file: FileId) -> &str {
        self.out.text(&self.out.files[file.0])
    }

    /// Adds files with their symbols and scopes; `input` is that of the first.
    pub(super) fn add(&mut self, modules: &[Module], input: &Input) {
        let base = self.out.files.len();
        for (m, module) in modules.iter().enumerate() {
            let file = FileId(self.out.files.len());
            let path = match m {
                0 => Path::new(input.name).to_path_buf(),
                _ => input.folder.join(&module.path),
            };
            let source = self.out.sources.text_of(module.source);
            self.out.files.push(File { path, source, syntax: Some(module.syntax) });
            self.scopes.push(Scope::default());
            self.own_names(file, module);
        }
        let mut done = vec![false; modules.len()];
        for m in 0..modules.len() {
            self.scope(m, base, modules, &mut done);
        }
    }

    /// Declares the symbols of a file, and adds its top-level names to its scope.
    fn own_names(&mut self, file: FileId, module: &Module) {
        let first = self.out.symbols.len();
        self.declare_spec(file, &module.spec);
        let mut starts = BTreeMap::new();
        let scope = &mut self.scopes[file.0].declared;
        for (i, symbol) in self.out.symbols.iter().enumerate().skip(first) {
            starts.entry(symbol.place.start).or_insert(SymbolId(i));
            if let Some(class) = class_of(symbol.kind).filter(|_| symbol.name.contains("${")) {
                scope.entry((class, symbol.name.clone())).or_insert(SymbolId(i));
            }
        }
        for (key, target) in &module.scope {
            let Target::Own(i) = target else { continue };
            let item = &module.items[*i].kind;
            let Some(id) = declared(item).and_then(|(_, name)| at(&starts, name.span)) else { continue };
            self.scopes[file.0].declared.insert(key.clone(), id);
            self.filled(id, item, &starts);
        }
    }

    /// Adds the names that the expansion makes of names with holes inside a declaration.
    fn filled(&mut self, outer: SymbolId, item: &ItemKind, starts: &BTreeMap<usize, SymbolId>) {
        fn states(r: &mut Resolver, outer: SymbolId, body: &StateBody, starts: &BTreeMap<usize, SymbolId>) {
            for s in &body.states {
                if let Some(id) = r.called(outer, &s.name, starts) {
                    states(r, id, &s.body, starts);
                }
            }
        }
        fn members(r: &mut Resolver, outer: SymbolId, all: &[MissionMember], starts: &BTreeMap<usize, SymbolId>) {
            for m in all {
                if let Some(id) = r.called(outer, &m.name, starts) {
                    members(r, id, &m.members, starts);
                }
            }
        }
        match item {
            ItemKind::Machine(m) => states(self, outer, &m.body, starts),
            ItemKind::Mission(m) => members(self, outer, &m.members, starts),
            ItemKind::Stack(s) => {
                for level in declared_levels(s) {
                    self.called(outer, &level.name, starts);
                }
            }
            _ => {}
        }
    }

    fn called(
        &mut self,
        outer: SymbolId,
        name: &Spanned<String>,
        starts: &BTreeMap<usize, SymbolId>,
    ) -> Option<SymbolId> {
        let id = at(starts, name.span)?;
        let known = self.inside.entry((outer, name.value.clone())).or_default();
        if !known.contains(&id) {
            known.push(id);
        }
        Some(id)
    }

    /// Completes the scope of a file by the names that it imports. Imports have no circles.
    fn scope(&mut self, m: usize, base: usize, modules: &[Module], done: &mut Vec<bool>) {
        if std::mem::replace(&mut done[m], true) {
            return;
        }
        let file = base + m;
        for ((class, visible), target) in &modules[m].scope {
            let Target::Imported { module, name, .. } = target else { continue };
            self.scope(*module, base, modules, done);
            let Some(mut id) = self.scopes[base + module].declared.get(&(*class, name.clone())).copied() else {
                continue;
            };
            if visible != name {
                id = self.renamed(FileId(file), id, (visible, name), &modules[m].spec).unwrap_or(id);
            }
            self.scopes[file].declared.insert((*class, visible.clone()), id);
            if *class == Class::Robot {
                let parts: Vec<_> = self.scopes[base + module].parts.iter().map(|(k, id)| (k.clone(), *id)).collect();
                for (key, id) in parts {
                    self.scopes[file].parts.entry(key).or_insert(id);
                }
            }
        }
        for item in &modules[m].spec.items {
            if let ItemKind::Stack(stack) = &item.kind {
                let named = |name: &str| self.scopes[file].declared.get(&(Class::Stack, name.to_string())).copied();
                let base = stack.base.as_ref().and_then(|base| named(&base.name.value));
                self.bases.extend(named(&stack.name.value).zip(base));
            }
        }
        if file == 0 {
            self.import_references(&modules[0], modules);
        }
    }

    /// Declares the name that an import chooses for a symbol.
    fn renamed(
        &mut self,
        file: FileId,
        target: SymbolId,
        (visible, name): (&str, &str),
        spec: &Spec,
    ) -> Option<SymbolId> {
        let imports = spec.items.iter().filter_map(|item| match &item.kind {
            ItemKind::Import(import) => Some(&import.names),
            _ => None,
        });
        let mut names = imports.flatten();
        let wanted = names.find(|n| n.name.value == name && n.visible().value == visible)?;
        let there = self.out.symbol(target);
        let (kind, ty, parameters, doc) = (there.kind, there.ty.clone(), there.parameters.clone(), there.doc.clone());
        let chosen = wanted.visible();
        let id = self.declare(file, &New::of(kind, chosen, wanted.name.span.to(chosen.span)))?;
        let symbol = &mut self.out.symbols[id.0];
        (symbol.ty, symbol.parameters, symbol.doc, symbol.imported) = (ty, parameters, doc, Some(target));
        Some(id)
    }

    /// References of the names in imports of the spec.
    fn import_references(&mut self, module: &Module, modules: &[Module]) {
        let spec = module.spec.clone();
        for item in &spec.items {
            let ItemKind::Import(import) = &item.kind else { continue };
            let from = module.imports.iter().find(|(path, _)| *path == import.path.value).and_then(|(_, m)| *m);
            self.named_file(&import.path.value, import.path.span, from.map(FileId));
            for wanted in &import.names {
                if self.is_cursor(&wanted.name.value, |r| r.importable(from, modules, import)) {
                    continue;
                }
                if wanted.alias.is_some() && self.is_cursor(&wanted.visible().value, |_| CompletionContext::Nothing) {
                    continue;
                }
                let Some(from) = from else { continue };
                let mut known = false;
                for class in CLASSES {
                    let found = self.scopes[from].declared.get(&(class, wanted.name.value.clone())).copied();
                    if let Some(id) = found {
                        self.note(&wanted.name.value, wanted.name.span, Meaning::Symbol(id));
                        known = true;
                    }
                }
                if !known {
                    let unknown = Meaning::Unknown(SymbolKind::Param, wanted.name.value.clone());
                    self.note(&wanted.name.value, wanted.name.span, unknown);
                }
            }
        }
    }

    /// Names that an import could bring, except for those that it brings.
    fn importable(&self, from: Option<usize>, modules: &[Module], import: &dsl::tree::Import) -> CompletionContext {
        let Some(from) = from.filter(|from| *from < modules.len()) else { return CompletionContext::Nothing };
        let new = self.scopes[from]
            .declared
            .iter()
            .filter(|((_, name), _)| !name.contains("${") && import.names.iter().all(|n| n.name.value != *name));
        let one = |((_, name), id): (&(Class, String), &SymbolId)| Offered {
            name: name.clone(),
            about: self.out.symbol(*id).kind.word(),
        };
        CompletionContext::Offered(new.map(one).collect())
    }

    fn named_file(&mut self, written: &str, span: Span, file: Option<FileId>) {
        if let Some(file) = file {
            self.named_files.insert(written.to_string(), file);
        }
        self.note(written, span, Meaning::File(file));
    }

    /// Records the specs that the workers of a mission run.
    pub(super) fn controllers(&mut self, outer: SymbolId, members: &[MissionMember], repeats: &[MissionRepeat]) {
        for m in members {
            let file = spec_of(m).and_then(|spec| self.named_files.get(spec).copied());
            self.controllers.extend(self.inside(outer, SymbolKind::Member, &m.name.value).zip(file));
        }
        repeats.iter().for_each(|r| self.controllers(outer, &r.members, &r.repeats));
    }

    /// Adds the specs that workers of the spec's missions run.
    pub(super) fn workers(&mut self, own: &Module, input: &Input, texts: &Texts) {
        for written in own.workers() {
            if self.named_files.contains_key(written) {
                continue;
            }
            let path = input.folder.join(written);
            let Some(syntax) = Syntax::of_path(&path) else { continue };
            let instead = path.canonicalize().ok().and_then(|canonical| texts.get(&canonical).cloned());
            let read = || read_file(&path).ok().and_then(|bytes| String::from_utf8(bytes).ok());
            let Some(text) = instead.or_else(read) else {
                self.out.missing.push(path);
                continue;
            };
            let name = path.display().to_string();
            let folder = path.parent().unwrap_or(Path::new(""));
            let there = Input { name: &name, text: &text, syntax, folder, ..*input };
            let source: SourceId = self.out.sources.add(name.as_str(), text.as_str());
            let (spec, _) = dsl::parse(source, &text, syntax);
            let read = read_files((&there, texts), source, spec, &mut self.out.sources);
            self.out.missing.extend(read.iter().flat_map(|m| m.missing.iter().cloned()));
            self.named_files.insert(written.to_string(), FileId(self.out.files.len()));
            self.add(&read, &there);
        }
    }

    /// Adds the URDF that the spec or one of its imports names, with its links and joints.
    pub(super) fn urdf(&mut self, modules: &[Module], input: &Input, read: &dyn Fn(&Path) -> Option<Rc<Urdf>>) {
        let robots = modules.iter().flat_map(|m| &m.items).filter_map(|item| match &item.kind {
            ItemKind::Robot(robot) => Some(robot),
            _ => None,
        });
        let words = robots.filter_map(|r| r.body.get("base")?.value.word());
        let moves = |word: &str| [Base::Planar, Base::Unicycle, Base::Floating].into_iter().find(|b| b.word() == word);
        for base in words.filter_map(moves) {
            self.base_names.extend(base.coordinate_names().iter().chain(base.dof_names()).copied());
            self.base_names.insert(ORIENTATION);
        }
        let named = modules.iter().flat_map(|m| m.urdfs().map(move |written| (m, written)));
        let mut paths: Vec<PathBuf> = Vec::new();
        for (module, written) in named {
            let path = input.folder.join(&module.folder).join(written);
            if !paths.contains(&path) {
                paths.push(path);
            }
        }
        for path in paths {
            if let Some(urdf) = read(&path) {
                self.add_urdf(path, &urdf);
            }
        }
    }

    /// Adds the links and joints of a URDF. Names of an earlier one take precedence.
    fn add_urdf(&mut self, path: PathBuf, urdf: &Urdf) {
        let file = FileId(self.out.files.len());
        let source = self.out.sources.add(path.display().to_string(), urdf.text.as_str());
        self.out.files.push(File { path, source, syntax: None });
        let mut add = |kind: SymbolKind, parts: &BTreeMap<String, super::urdf::UrdfPart>| {
            let one = |(name, part): (&String, &super::urdf::UrdfPart)| {
                let symbol = Symbol {
                    kind,
                    name: name.clone(),
                    file,
                    place: part.place.clone(),
                    whole: part.whole.clone(),
                    container: None,
                    doc: vec![part.doc.clone()],
                    ty: part.ty.clone(),
                    parameters: Vec::new(),
                    imported: None,
                };
                (name.clone(), self.add_symbol(symbol))
            };
            parts.iter().map(one).collect::<BTreeMap<_, _>>()
        };
        let (links, joints) = (add(SymbolKind::Link, &urdf.links), add(SymbolKind::Joint, &urdf.joints));
        for (all, new) in [(&mut self.links, links), (&mut self.joints, joints)] {
            let all = all.get_or_insert_default();
            for (name, id) in new {
                all.entry(name).or_insert(id);
            }
        }
    }

    /// Adds the SRDF that the spec or one of its imports names, with its groups and postures. Declarations of the spec, and for
    /// groups of links also links, take precedence.
    pub(super) fn srdf(&mut self, modules: &[Module], input: &Input) {
        for (module, written) in modules.iter().flat_map(|m| m.srdfs().map(move |written| (m, written))) {
            self.add_srdf(input.folder.join(&module.folder).join(written));
        }
    }

    fn add_srdf(&mut self, path: PathBuf) {
        let Some(names) = read_srdf(&path) else { return };
        let file = FileId(self.out.files.len());
        let source = self.out.sources.add(path.display().to_string(), names.text.as_str());
        self.out.files.push(File { path, source, syntax: None });
        self.srdf = Some(file);
        let kinds = [
            (SymbolKind::JointGroup, &names.groups),
            (SymbolKind::Group, &names.groups),
            (SymbolKind::Arm, &names.chains),
            (SymbolKind::Posture, &names.postures),
        ];
        for (kind, parts) in kinds {
            for (name, part) in parts {
                let is_link = kind == SymbolKind::Group && self.links.as_ref().is_some_and(|l| l.contains_key(name));
                let is_joint =
                    kind == SymbolKind::JointGroup && self.joints.as_ref().is_some_and(|j| j.contains_key(name));
                if is_link
                    || is_joint
                    || self.scopes.first().is_none_or(|s| s.parts.contains_key(&(kind, name.clone())))
                {
                    continue;
                }
                let id = self.add_symbol(Symbol {
                    kind,
                    name: name.clone(),
                    file,
                    place: part.place.clone(),
                    whole: part.whole.clone(),
                    container: None,
                    doc: vec![part.doc.clone()],
                    ty: String::new(),
                    parameters: Vec::new(),
                    imported: None,
                });
                self.scopes[0].parts.insert((kind, name.clone()), id);
            }
        }
    }

    /// Sorts the references, and lists the names that the spec sees.
    pub(super) fn finish(mut self) -> Resolution {
        let own = self.scopes.into_iter().next().unwrap_or_default();
        let declared = own.declared.into_iter().map(|((_, name), id)| (name, id));
        let parts = own.parts.into_iter().map(|((_, name), id)| (name, id));
        let urdf = self.links.into_iter().chain(self.joints).flatten();
        for (name, id) in declared.chain(parts).chain(own.raised).chain(urdf).filter(|(name, _)| !name.contains("${")) {
            self.out.names.entry(self.out.symbols[id.0].kind).or_default().insert((name, id));
        }
        self.out.references.sort_by_key(|r| (r.place.start, r.place.end));
        self.out
    }
}
