-- Save this as `~/.config/nvim/plugin/hierarq.lua`, and `hierarq.vim` as `~/.config/nvim/syntax/hierarq.vim`.
-- For Neovim 0.7 or newer; no plugin is needed.

local command = { "hierarq", "lsp" }

-- Neovim 0.7 has no `vim.lsp.start`, which reuses the server of a folder.
local clients = {}

local function start(buffer)
  local folder = vim.fn.fnamemodify(vim.api.nvim_buf_get_name(buffer), ":p:h")
  local config = { name = "hierarq", cmd = command, root_dir = folder }
  if vim.lsp.start then
    vim.lsp.start(config, { bufnr = buffer })
    return
  end
  if not (clients[folder] and vim.lsp.get_client_by_id(clients[folder])) then
    clients[folder] = vim.lsp.start_client(config)
  end
  if clients[folder] then
    vim.lsp.buf_attach_client(buffer, clients[folder])
  end
end

vim.api.nvim_create_autocmd({ "BufRead", "BufNewFile" }, {
  pattern = "*.hq",
  callback = function()
    vim.bo.filetype = "hierarq"
  end,
})

vim.api.nvim_create_autocmd("FileType", {
  pattern = { "hierarq", "yaml" },
  callback = function(event)
    local buffer = event.buf
    if vim.bo[buffer].filetype == "hierarq" then
      vim.bo[buffer].commentstring = "// %s"
      vim.bo[buffer].omnifunc = "v:lua.vim.lsp.omnifunc"
      start(buffer)
      return
    end
    -- Of YAML only what is a spec.
    for _, line in ipairs(vim.api.nvim_buf_get_lines(buffer, 0, 50, false)) do
      if line:match("^hierarq:") then
        vim.bo[buffer].omnifunc = "v:lua.vim.lsp.omnifunc"
        start(buffer)
        return
      end
    end
  end,
})
