-- The session of `session.sh`. It runs as a coroutine, so that Neovim handles keys and messages in between.

local failures = 0

local function say(text)
  io.stdout:write(text, "\n")
end

local function check(what, good, shown)
  failures = failures + (good and 0 or 1)
  shown = type(shown) == "table" and table.concat(shown, "\n") or tostring(shown or "")
  say((good and "there    " or "MISSING  ") .. what)
  for line in shown:gmatch("[^\n]+") do
    say("         | " .. line)
  end
end

-- Lets Neovim work until something holds, for at most some seconds; returns what it gave last.
local function await(holds, seconds)
  local me = coroutine.running()
  for _ = 1, (seconds or 10) * 20 do
    local value = holds()
    if value then
      return value
    end
    vim.defer_fn(function()
      coroutine.resume(me)
    end, 50)
    coroutine.yield()
  end
  return holds()
end

local function text()
  return table.concat(vim.api.nvim_buf_get_lines(0, 0, -1, false), "\n")
end

-- Puts the cursor where `|` stands in a piece of the text.
local function go(piece)
  local mark = piece:find("|", 1, true)
  local plain = piece:sub(1, mark - 1) .. piece:sub(mark + 1)
  local at = assert(text():find(plain, 1, true), plain .. " is not in this text") + mark - 2
  local before = text():sub(1, at)
  local _, row = before:gsub("\n", "")
  vim.api.nvim_win_set_cursor(0, { row + 1, #before:match("[^\n]*$") })
end

local function change(old, new)
  local from, to = text():find(old, 1, true)
  assert(from, old .. " is not in this text")
  local whole = text():sub(1, from - 1) .. new .. text():sub(to + 1)
  vim.api.nvim_buf_set_lines(0, 0, -1, false, vim.split(whole, "\n", { plain = true }))
end

local function diagnostics()
  local all = {}
  for _, d in ipairs(vim.diagnostic.get(0)) do
    table.insert(all, ("%d:%d %s %s"):format(d.lnum + 1, d.col + 1, d.code or "", d.message))
  end
  return all
end

local function attached()
  if vim.lsp.get_clients then
    return vim.lsp.get_clients({ bufnr = 0 })[1]
  end
  return next(vim.lsp.buf_get_clients(0))
end

local function open(file)
  vim.cmd("edit! " .. file)
  return await(attached)
end

-- Asks the server by hand.
local function ask(method, more)
  local params = vim.tbl_extend("force", vim.lsp.util.make_position_params(0, "utf-16"), more or {})
  local answer
  vim.lsp.buf_request(0, method, params, function(_, result)
    answer = { result }
  end)
  await(function()
    return answer
  end)
  return answer and answer[1] or {}
end

local function floating()
  for _, window in ipairs(vim.api.nvim_list_wins()) do
    if vim.api.nvim_win_get_config(window).relative ~= "" then
      return vim.api.nvim_buf_get_lines(vim.api.nvim_win_get_buf(window), 0, -1, false), window
    end
  end
end

local function hover(piece, says)
  go(piece)
  vim.lsp.buf.hover()
  local lines = await(floating) or {}
  local _, window = floating()
  if window then
    vim.api.nvim_win_close(window, true)
  end
  local good = table.concat(lines, "\n"):find(says, 1, true) ~= nil
  check("hover at " .. piece, good, { unpack(lines, 1, 4) })
end

-- Types at a place, presses Ctrl-X Ctrl-O, and reads the menu.
local function complete(piece, typed, wanted)
  local before = text()
  go(piece)
  vim.api.nvim_input("i" .. typed .. "<C-x><C-o>")
  local words = await(function()
    local items = vim.fn.complete_info({ "items" }).items
    return #items > 0 and vim.tbl_map(function(i)
      return i.word
    end, items)
  end) or {}
  vim.api.nvim_input("<C-e><Esc>")
  await(function()
    return vim.api.nvim_get_mode().mode == "n"
  end)
  vim.api.nvim_buf_set_lines(0, 0, -1, false, vim.split(before, "\n", { plain = true }))
  local good = vim.tbl_contains(words, wanted)
  for _, word in ipairs(words) do
    good = good and vim.startswith(word, typed)
  end
  check(("completion at %s after typing %q"):format(piece, typed), good, table.concat(words, " "):sub(1, 100))
end

local function definition(piece, file, line)
  go(piece)
  local from = vim.api.nvim_buf_get_name(0)
  vim.lsp.buf.definition()
  local name, here
  local found = await(function()
    name = vim.fn.fnamemodify(vim.api.nvim_buf_get_name(0), ":t")
    here = vim.api.nvim_get_current_line()
    return name == file and here:find(line, 1, true)
  end)
  check("definition of " .. piece, found, name .. ": " .. here)
  vim.cmd("buffer! " .. vim.fn.fnameescape(from))
end

local function colour(piece, wanted)
  go(piece)
  local at = vim.api.nvim_win_get_cursor(0)
  local group = vim.fn.synIDattr(vim.fn.synID(at[1], at[2] + 1, 1), "name")
  check("colour at " .. piece, group == wanted, group)
end

local function session()
  vim.o.hidden = true
  vim.o.lines, vim.o.columns = 50, 140
  local version = vim.version()
  say(("Neovim %d.%d.%d"):format(version.major, version.minor, version.patch))

  check("a server for own_tasks.hq", open("own_tasks.hq"), vim.bo.filetype)
  change("distance(arms, chest)", "distance(arms, chset)")
  await(function()
    return #diagnostics() > 0
  end)
  check("a diagnostic", (diagnostics()[1] or ""):find("chset") ~= nil, diagnostics())

  local offered = {}
  vim.ui.select = function(items, options, choose)
    for _, item in ipairs(items) do
      table.insert(offered, options.format_item and options.format_item(item) or item)
    end
    choose(items[1], 1)
  end
  go("ch|set")
  vim.lsp.buf.code_action()
  local mended = await(function()
    return text():find("distance(arms, chest)", 1, true) and #diagnostics() == 0
  end)
  check("a quick fix, and no diagnostic after it", mended, offered)

  hover("task grip = tr|ack", "track")
  hover("param cl|ear", "clear")
  hover("min(dis|tance", "distance")
  complete("{ min clear | gain", "sa", "sampled_margin")
  complete("joint(|torso_lift)", "", "torso_lift")
  definition("frame(left|_tool).position + frame(right", "canopies.urdf", '<link name="left_tool"')

  go("param cl|ear")
  vim.lsp.buf.references()
  local uses = await(function()
    local list = vim.fn.getqflist()
    return #list > 0 and list
  end) or {}
  vim.cmd("cclose")
  check("references", #uses == 2, #uses .. " places: the param and its use")

  go("param cl|ear")
  vim.lsp.buf.rename("clearance")
  local renamed = await(function()
    return text():find("{ min clearance", 1, true)
  end)
  check("rename", renamed and text():find("param clearance", 1, true), text():match("[^\n]*min clearance[^\n]*"))

  change("param step = 0.12 m", "param   step=0.12   m")
  if vim.lsp.buf.format then
    vim.lsp.buf.format({ timeout_ms = 5000 })
  else
    vim.lsp.buf.formatting_sync(nil, 5000)
  end
  check("formatting", text():find("\nparam step = 0.12 m\n", 1, true), text():match("param +step[^\n]*"))

  local document = { textDocument = vim.lsp.util.make_text_document_params() }
  if vim.lsp.inlay_hint and vim.lsp.inlay_hint.get then
    vim.lsp.inlay_hint.enable(true, { bufnr = 0 })
    local hints = await(function()
      local all = vim.lsp.inlay_hint.get({ bufnr = 0 })
      return #all > 0 and all
    end) or {}
    check("inlay hints, drawn", #hints > 0, hints[1] and hints[1].inlay_hint.label)
  else
    local ends = { start = { line = 0, character = 0 }, ["end"] = { line = 200, character = 0 } }
    local hints = ask("textDocument/inlayHint", { textDocument = document.textDocument, range = ends })
    check("inlay hints, asked for by hand (0.10 draws them)", #hints > 0, hints[1] and hints[1].label)
  end
  if vim.lsp.semantic_tokens then
    local token = await(function()
      go("task grip = tr|ack")
      local at = vim.api.nvim_win_get_cursor(0)
      return vim.lsp.semantic_tokens.get_at_pos(0, at[1] - 1, at[2])[1]
    end)
    check("colours by meaning", token and token.type == "type", token and token.type)
  end
  local symbols = vim.tbl_map(function(s)
    return s.name
  end, ask("textDocument/documentSymbol", document))
  check("outline", vim.tbl_contains(symbols, "grip"), table.concat(symbols, " "))

  check("a server for cooperative_motion.hq", open("cooperative_motion.hq"))
  definition("collision hard { de|ck", "canopies.hq", "task deck")
  definition('import "common/can|opies.hq"', "canopies.hq", "//")
  hover("hard { deck  torso_cl|ear", "self_collision")

  check("a server for words.hq", open("../editors/words.hq"))
  hover("im|port \"", "Names of another spec")
  hover("le|t late", "named expression")
  hover("fo|r side", "Repeats")
  hover("{ m|in 0 m", "least value")
  hover("orientation in left|_tool", "link `left_tool`")
  hover("[reach, 0, 0.02 m * la|te]", "let late")
  hover("guarded(left, ho|ld(right))", "hold")
  complete("(side: |arm, offset", "", "geometry")
  complete("from |guarded", "", "guarded")
  complete("deck as table, |arms_apart", "", "head_clear")
  complete("replace |motion", "", "posture")
  definition("frame_position(si|de) {", "words.hq", "task swing_out(side")
  definition("add last { touch_left  touch_right } after po|sture", "words.hq", "level posture")
  go("swing_out(side: arm, off|set")
  vim.lsp.buf.rename("shift")
  await(function()
    return text():find("shift: [0, 0, reach]", 1, true)
  end)
  check("rename of a parameter", text():find("swing_out(right, shift: [0, 0, reach]", 1, true),
    text():match("[^\n]*shift%*[^\n]*"))
  await(function()
    return #diagnostics() == 0
  end)
  check("no diagnostic after it", #diagnostics() == 0, diagnostics())

  colour("im|port \"", "hierarqKeyword")
  colour("// The wo|rds", "hierarqComment")
  colour("canopies.h|q\"", "hierarqString")
  colour("deck a|s table", "hierarqKeyword")
  colour("= 0.|08", "hierarqNumber")
  colour("0.08 |m {", "hierarqUnit")
  colour("{ m|in 0 m", "")
  colour("2 s an|d not", "hierarqOperator")
  colour("fo|r side in", "hierarqKeyword")
  colour("for side i|n [", "hierarqKeyword")
  colour("orientation i|n left_tool", "hierarqOperator")
  colour("touch_$|{side} =", "hierarqHole")
  colour("side: ar|m", "hierarqType")
  colour("= frame_po|sition(side) {", "hierarqType")
  colour("fr|om canopies", "hierarqKeyword")
  colour("rep|lace motion", "hierarqKeyword")
  colour("be|fore posture", "hierarqKeyword")
  colour("re|move posture", "hierarqKeyword")
  colour("limits ha|rd", "hierarqModifier")

  check("a server for own_tasks.yaml", open("../examples/own_tasks.yaml"), vim.bo.filetype)
  hover("tr|ack:", "track")
  vim.cmd("edit! ../other.yaml")
  check("none for another YAML file", not await(attached, 1))
end

local function guarded()
  local good, trouble = xpcall(session, debug.traceback)
  check("the end of the session", good, trouble)
  say(failures == 0 and "all is there" or failures .. " missing")
  vim.cmd(failures == 0 and "qall!" or "cquit 1")
end

vim.schedule(coroutine.wrap(guarded))
