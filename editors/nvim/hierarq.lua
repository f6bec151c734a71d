-- Save this as `~/.config/nvim/plugin/hierarq.lua` (Neovim 0.8 or newer).

vim.filetype.add({ extension = { hq = "hierarq" } })

local function start(buffer)
  local name = vim.api.nvim_buf_get_name(buffer)
  vim.lsp.start({
    name = "hierarq",
    cmd = { "hierarq", "lsp" },
    root_dir = vim.fs.dirname(name),
  })
end

vim.api.nvim_create_autocmd("FileType", {
  pattern = { "hierarq", "yaml" },
  callback = function(event)
    if vim.bo[event.buf].filetype == "hierarq" then
      vim.bo[event.buf].commentstring = "// %s"
      start(event.buf)
      return
    end
    -- Of YAML only what is a spec.
    for _, line in ipairs(vim.api.nvim_buf_get_lines(event.buf, 0, 50, false)) do
      if line:match("^hierarq:") then
        start(event.buf)
        return
      end
    end
  end,
})
