#!/usr/bin/env bash
# A session in a real Neovim without a screen: the files of this folder are installed as the book says, copies of the
# examples are opened, mistakes are made, and what the editor got is printed. Fails where something is not there.
#
#   editors/nvim/session.sh [NVIM] [HIERARQ]
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
nvim="${1:-nvim}"
hierarq="$(realpath "${2:-$root/target/release/hierarq}")"

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
export HOME="$work/home" XDG_CONFIG_HOME="$work/config" XDG_DATA_HOME="$work/data" XDG_STATE_HOME="$work/state"
mkdir -p "$HOME" "$work/bin" "$work/editors" "$XDG_CONFIG_HOME/nvim/plugin" "$XDG_CONFIG_HOME/nvim/syntax"
ln -s "$hierarq" "$work/bin/hierarq"
cp "$here/hierarq.lua" "$XDG_CONFIG_HOME/nvim/plugin/"
cp "$here/hierarq.vim" "$XDG_CONFIG_HOME/nvim/syntax/"
cp -r "$root/examples" "$work/examples"
cp "$root/editors/words.hq" "$work/editors/"
printf 'name: not a spec\n' > "$work/other.yaml"

cd "$work/examples"
PATH="$work/bin:$PATH" timeout 180 "$nvim" --headless -n -c "luafile $here/session.lua"
