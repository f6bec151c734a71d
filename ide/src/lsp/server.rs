//! State of the server, and dispatch of requests and notifications.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::rc::Rc;

use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{self as note, Notification as _};
use lsp_types::request::{self as ask, Request as _};
use lsp_types::{
    CodeActionKind, CodeActionOptions, CodeActionProviderCapability, CompletionOptions, CompletionResponse,
    DidChangeTextDocumentParams, DidChangeWorkspaceFoldersParams, DidCloseTextDocumentParams,
    DidOpenTextDocumentParams, DocumentSymbolResponse, GotoDefinitionResponse, HoverProviderCapability,
    InitializeParams, OneOf, PublishDiagnosticsParams, Range, RenameOptions, SemanticTokens, SemanticTokensFullOptions,
    SemanticTokensLegend, SemanticTokensOptions, SemanticTokensResult, SemanticTokensServerCapabilities,
    ServerCapabilities, TextDocumentPositionParams, TextDocumentSyncCapability, TextDocumentSyncKind,
    TextDocumentSyncOptions, TextEdit, Uri, WorkDoneProgressOptions, WorkspaceEdit, WorkspaceFoldersServerCapabilities,
    WorkspaceServerCapabilities, WorkspaceSymbolResponse,
};

use super::document::Document;
use super::library::Library;
use super::workspace::Workspace;
use super::{actions, completion, diagnostics, hover, inlay, navigation, rename, symbols, tokens, uri, workspace};

/// Capabilities of the server.
pub(super) fn capabilities() -> ServerCapabilities {
    ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Options(TextDocumentSyncOptions {
            open_close: Some(true),
            change: Some(TextDocumentSyncKind::INCREMENTAL),
            save: Some(true.into()),
            ..TextDocumentSyncOptions::default()
        })),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(["{", "[", "(", ".", "/"].map(String::from).to_vec()),
            ..CompletionOptions::default()
        }),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        document_highlight_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        workspace_symbol_provider: Some(OneOf::Left(true)),
        workspace: Some(WorkspaceServerCapabilities {
            workspace_folders: Some(WorkspaceFoldersServerCapabilities {
                supported: Some(true),
                change_notifications: Some(OneOf::Left(true)),
            }),
            file_operations: None,
        }),
        code_action_provider: Some(CodeActionProviderCapability::Options(CodeActionOptions {
            code_action_kinds: Some(vec![CodeActionKind::QUICKFIX]),
            ..CodeActionOptions::default()
        })),
        inlay_hint_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        semantic_tokens_provider: Some(SemanticTokensServerCapabilities::SemanticTokensOptions(
            SemanticTokensOptions {
                legend: SemanticTokensLegend { token_types: tokens::legend(), token_modifiers: Vec::new() },
                full: Some(SemanticTokensFullOptions::Bool(true)),
                ..SemanticTokensOptions::default()
            },
        )),
        ..ServerCapabilities::default()
    }
}

/// Error response to a request.
struct Refusal(ErrorCode, String);

/// State of the server: the open documents.
#[derive(Default)]
pub(super) struct Server {
    /// Folders of the workspace.
    roots: Vec<PathBuf>,
    /// All texts.
    library: Rc<Library>,
    documents: BTreeMap<Uri, Document>,
    /// Documents whose diagnostics are outdated.
    changed: BTreeSet<Uri>,
}

/// Folder of an address.
fn root(uri: &Uri) -> Option<PathBuf> {
    uri::absolute(&uri::path(uri)?)
}

/// Calls a function and catches a panic, which then costs this response and not the session.
fn guarded<T>(f: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(f)).ok()
}

impl Server {
    /// Creates a server for the workspace of an editor.
    #[allow(deprecated, reason = "editors without folders of a workspace tell of one root")]
    pub fn of(params: &InitializeParams) -> Server {
        let folders = params.workspace_folders.iter().flatten().map(|f| &f.uri);
        let mut roots: Vec<PathBuf> = folders.filter_map(root).collect();
        if roots.is_empty() {
            roots.extend(params.root_uri.as_ref().and_then(root));
        }
        Server { roots, ..Server::default() }
    }

    /// Computes the diagnostics of one changed document, if there is one.
    pub fn publish(&mut self) -> Option<Message> {
        let uri = self.changed.pop_first()?;
        let document = self.documents.get(&uri);
        let diagnostics = document.and_then(|d| guarded(|| diagnostics::of(d))).unwrap_or_default();
        let params = PublishDiagnosticsParams { uri, diagnostics, version: document.map(|d| d.version) };
        Some(Notification::new(note::PublishDiagnostics::METHOD.to_string(), params).into())
    }

    /// Handles a notification. Invalid ones are ignored, since the protocol has no response to them.
    pub fn note(&mut self, n: Notification) {
        match n.method.as_str() {
            note::DidOpenTextDocument::METHOD => {
                if let Ok(p) = serde_json::from_value::<DidOpenTextDocumentParams>(n.params) {
                    let document = Document::open(p.text_document, self.library.clone());
                    self.touched(&document.uri);
                    self.changed.insert(document.uri.clone());
                    self.documents.insert(document.uri.clone(), document);
                }
            }
            note::DidChangeTextDocument::METHOD => {
                let Ok(p) = serde_json::from_value::<DidChangeTextDocumentParams>(n.params) else { return };
                let Some(document) = self.documents.get_mut(&p.text_document.uri) else { return };
                let text = p.content_changes.iter().fold(document.text.clone(), |text, change| text.changed(change));
                document.change(text, p.text_document.version);
                self.touched(&p.text_document.uri);
                self.changed.insert(p.text_document.uri);
            }
            note::DidCloseTextDocument::METHOD => {
                if let Ok(p) = serde_json::from_value::<DidCloseTextDocumentParams>(n.params) {
                    // A closed document has no diagnostics.
                    self.touched(&p.text_document.uri);
                    if let Some(document) = self.documents.remove(&p.text_document.uri) {
                        self.library.close(&document.place());
                    }
                    self.changed.insert(p.text_document.uri);
                }
            }
            note::DidChangeWorkspaceFolders::METHOD => {
                let Ok(p) = serde_json::from_value::<DidChangeWorkspaceFoldersParams>(n.params) else { return };
                let gone: Vec<PathBuf> = p.event.removed.iter().filter_map(|f| root(&f.uri)).collect();
                self.roots.retain(|r| !gone.contains(r));
                self.roots.extend(p.event.added.iter().filter_map(|f| root(&f.uri)));
            }
            // Another file that the spec depends on may have changed too.
            note::DidSaveTextDocument::METHOD => {
                for document in self.documents.values_mut() {
                    document.refresh();
                }
                self.changed.extend(self.documents.keys().cloned());
            }
            _ => {}
        }
    }

    fn opened(&self) -> Vec<&Document> {
        self.documents.values().collect()
    }

    fn workspace<'s>(&'s self, opened: &'s [&'s Document]) -> Workspace<'s> {
        Workspace { documents: opened, roots: &self.roots, library: &self.library }
    }

    /// Invalidates the analyses that depend on this document.
    fn touched(&mut self, uri: &Uri) {
        let Some(place) = uri::path(uri).and_then(|p| uri::absolute(&p)) else { return };
        for document in self.documents.values_mut().filter(|d| d.uri != *uri && d.rests_on(&place)) {
            document.refresh();
            self.changed.insert(document.uri.clone());
        }
    }

    /// Responds to a request.
    pub fn answer(&self, request: Request) -> Response {
        let id = request.id.clone();
        let result = guarded(|| self.dispatch(request))
            .unwrap_or_else(|| Err(Refusal(ErrorCode::InternalError, "a fault in the server".to_string())));
        match result {
            Ok(value) => Response::new_ok(id, value),
            Err(Refusal(code, text)) => Response::new_err(id, code as i32, text),
        }
    }

    fn dispatch(&self, request: Request) -> Result<serde_json::Value, Refusal> {
        match request.method.as_str() {
            ask::HoverRequest::METHOD => {
                with::<ask::HoverRequest>(request, |p| Ok(self.at(&p.text_document_position_params, hover::of)))
            }
            ask::Completion::METHOD => with::<ask::Completion>(request, |p| {
                Ok(self.at(&p.text_document_position, completion::of).map(CompletionResponse::Array))
            }),
            ask::GotoDefinition::METHOD => with::<ask::GotoDefinition>(request, |p| {
                let found = self.at(&p.text_document_position_params, navigation::definition);
                Ok(found.map(GotoDefinitionResponse::Scalar))
            }),
            ask::References::METHOD => with::<ask::References>(request, |p| {
                let declaration = p.context.include_declaration;
                let opened = self.opened();
                let found = |d: &Document, byte| workspace::references(self.workspace(&opened), (d, byte), declaration);
                Ok(self.at(&p.text_document_position, found))
            }),
            ask::DocumentHighlightRequest::METHOD => with::<ask::DocumentHighlightRequest>(request, |p| {
                Ok(self.at(&p.text_document_position_params, navigation::highlights))
            }),
            ask::PrepareRenameRequest::METHOD => {
                with::<ask::PrepareRenameRequest>(request, |p| Ok(self.at(&p, rename::prepare)))
            }
            ask::Rename::METHOD => with::<ask::Rename>(request, |p| {
                let opened = self.opened();
                let renamed =
                    |d: &Document, byte| Some(rename::rename(self.workspace(&opened), (d, byte), &p.new_name));
                let renamed = self.at(&p.text_document_position, renamed);
                let edits = renamed.unwrap_or_else(|| Err("this document is not open".to_string()));
                let edits = edits.map_err(|text| Refusal(ErrorCode::RequestFailed, text))?;
                Ok(Some(WorkspaceEdit::new(edits.into_iter().collect())))
            }),
            ask::WorkspaceSymbolRequest::METHOD => with::<ask::WorkspaceSymbolRequest>(request, |p| {
                let found = workspace::symbols(self.workspace(&self.opened()), &p.query);
                Ok(Some(WorkspaceSymbolResponse::Nested(found)))
            }),
            ask::DocumentSymbolRequest::METHOD => with::<ask::DocumentSymbolRequest>(request, |p| {
                let document = self.documents.get(&p.text_document.uri);
                Ok(document.map(|d| DocumentSymbolResponse::Nested(symbols::of(d))))
            }),
            ask::Formatting::METHOD => {
                with::<ask::Formatting>(request, |p| Ok(self.documents.get(&p.text_document.uri).and_then(format)))
            }
            ask::CodeActionRequest::METHOD => with::<ask::CodeActionRequest>(request, |p| {
                let document = self.documents.get(&p.text_document.uri);
                Ok(document.and_then(|d| actions::of(d, p.range, &p.context)))
            }),
            ask::InlayHintRequest::METHOD => with::<ask::InlayHintRequest>(request, |p| {
                let document = self.documents.get(&p.text_document.uri);
                Ok(document.and_then(|d| inlay::of(d, d.text.byte(p.range.start)..d.text.byte(p.range.end))))
            }),
            ask::SemanticTokensFullRequest::METHOD => with::<ask::SemanticTokensFullRequest>(request, |p| {
                let document = self.documents.get(&p.text_document.uri);
                let tokens = document.map(|d| SemanticTokens { result_id: None, data: tokens::of(d) });
                Ok(tokens.map(SemanticTokensResult::Tokens))
            }),
            other => Err(Refusal(ErrorCode::MethodNotFound, format!("`{other}` is not known here"))),
        }
    }

    /// Evaluates a query at a position; `None` if the document is not open.
    fn at<T>(&self, p: &TextDocumentPositionParams, f: impl FnOnce(&Document, usize) -> Option<T>) -> Option<T> {
        let document = self.documents.get(&p.text_document.uri)?;
        f(document, document.text.byte(p.position))
    }
}

/// Deserializes the parameters of a request and serializes its result.
fn with<R: ask::Request>(
    request: Request,
    f: impl FnOnce(R::Params) -> Result<R::Result, Refusal>,
) -> Result<serde_json::Value, Refusal> {
    let params =
        serde_json::from_value(request.params).map_err(|e| Refusal(ErrorCode::InvalidParams, e.to_string()))?;
    serde_json::to_value(f(params)?).map_err(|e| Refusal(ErrorCode::InternalError, e.to_string()))
}

/// Edit that formats a document, from the first changed line to the last.
fn format(document: &Document) -> Option<Vec<TextEdit>> {
    let new = document.formatted()?;
    let old = document.text.as_str();
    if new == old {
        return Some(Vec::new());
    }
    let (a, b): (Vec<&str>, Vec<&str>) = (old.split_inclusive('\n').collect(), new.split_inclusive('\n').collect());
    let front = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let behind = a[front..].iter().rev().zip(b[front..].iter().rev()).take_while(|(x, y)| x == y).count();
    let start: usize = a[..front].iter().map(|l| l.len()).sum();
    let end: usize = a[..a.len() - behind].iter().map(|l| l.len()).sum();
    let range = Range::new(document.text.position(start), document.text.position(end));
    Some(vec![TextEdit::new(range, b[front..b.len() - behind].concat())])
}
