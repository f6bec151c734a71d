// Starts `hierarq lsp` and connects it to the editor. All that the editor shows comes from there.
"use strict";

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function activate() {
  const command = workspace.getConfiguration("hierarq").get("path", "hierarq");
  client = new LanguageClient(
    "hierarq",
    "Hierarq",
    { command, args: ["lsp"] },
    // The server leaves YAML alone that has no line `hierarq: 1`.
    { documentSelector: [{ language: "hierarq" }, { language: "yaml" }] },
  );
  return client.start();
}

function deactivate() {
  return client && client.stop();
}

module.exports = { activate, deactivate };
