" Colours of `.hq` specs: ~/.config/nvim/syntax/hierarq.vim. The language server adds what only the meaning tells
" (Neovim 0.9 or newer).
if exists("b:current_syntax")
  finish
endif

syntax case match
syntax iskeyword @,48-57,_

syntax match hierarqKeyword "^\s*\zs\%(hierarq\|import\|param\|let\|robot\|task\|stack\|signal\|human\|safety_field\|obstacle\|variable\|machine\|mission\|scenario\|expect\|check\|coverage\|run\|for\)\>"
syntax match hierarqKeyword "\<\%(level\|replace\|add\|remove\|before\|after\|from\|as\)\ze\s\+\%(\h\|\$\)"
syntax match hierarqKeyword "\<for\ze\s\+\h\w*\s\+in\>"
syntax match hierarqKeyword "\<\%(robot\|human\|worker\|object\|place\|layer\|source\|wall\|target\|obstacle\)\ze\s\+\%(\h\|\$\)\S*\s*{"
syntax match hierarqKeyword "\<task\ze\s\+\%(\h\|\$\)\S*\s*="
syntax match hierarqOperator "\<in\ze\s\+\h"
syntax match hierarqKeyword "\%(\<for\s\+\h\w*\s\+\)\@<=in\>"
syntax match hierarqKeyword "\<\%(state\|region\|final\|stack\|initial\|enter\|do\|exit\)\ze\s\+\%(\h\|\$\)"
syntax match hierarqKeyword "\<\%(on\|when\|after\|for\)\ze\s.*->"
syntax match hierarqKeyword "^\s*\zs\%(on\|when\)\ze\s"
syntax match hierarqKeyword "\%(^\s*\%(expect\|check\)\s.*\)\@<=\<\%(always\|eventually\|never\|within\|from\|to\|after\|until\|implies\)\>"
syntax match hierarqKeyword "\<allow\ze\s\+HQ\d\+\>"
syntax match hierarqConstant "\%(\<allow\s\+\)\@<=HQ\d\+\>"
syntax match hierarqOperator "->"
syntax keyword hierarqModifier hard weight blend timeout
syntax keyword hierarqConstant pi t time auto true false
syntax match hierarqFunction "\<\h\w*\ze("
syntax match hierarqType "\%(=\s*\)\@<=\h\w*\ze\s*\%({\|$\)"
syntax match hierarqType "\%(^\s*task\s.*=\s*\)\@<=\h\w*\ze("
syntax match hierarqType "\%(\h\w*:\s*\)\@<=\%(arm\|frame\|joints\|geometry\|task\|name\|number\|length\|angle\|duration\|rate\|speed\|angular_speed\|mass\|vector\|point\|orientation\|pose\)\>"
syntax match hierarqType "\%(^\s*\%(signal\|variable\)\s\+\h\w*\s*:\s*\)\@<=\%(event\|flag\|wrench\|\h\w*\)?\="
syntax match hierarqType "\%(^\s*mission\s\+\h\w*\s*:\s*\)\@<=\h\w*"
syntax match hierarqNumber "\<\d\+\%(\.\d\+\)\=\%([eE][-+]\=\d\+\)\=\>"
syntax match hierarqUnit "\%([0-9)\]/*]\s*\)\@<=\%(mrad\|turn\|rad\|deg\|kHz\|rpm\|cm\|mm\|km\|um\|ms\|us\|Hz\|kg\|kN\|mN\|Nm\|m\|s\|h\|g\|N\|J\|W\)\>"
syntax match hierarqUnit "\%([0-9)\]/*]\s*\)\@<=min\>\%(\s\+[-0-9[(A-Za-z_]\)\@!"
syntax match hierarqHole "\${[-+* 0-9]*\h[-+* 0-9A-Za-z_]*}"
syntax region hierarqString start=+"+ skip=+\\.+ end=+"+ oneline contains=hierarqHole
syntax match hierarqComment "//.*$" contains=@Spell

" `and`, `or` and `not` are operators inside brackets, behind `let`, and in conditions; elsewhere they are keys.
syntax match hierarqOperator "\%(^\s*\%(let\|param\|when\|expect\|check\)\s.*\)\@<=\<\%(and\|or\|not\)\>"

highlight default link hierarqKeyword Keyword
highlight default link hierarqModifier Keyword
highlight default link hierarqOperator Operator
highlight default link hierarqConstant Constant
highlight default link hierarqFunction Function
highlight default link hierarqType Type
highlight default link hierarqNumber Number
highlight default link hierarqUnit Number
highlight default link hierarqHole Identifier
highlight default link hierarqString String
highlight default link hierarqComment Comment

let b:current_syntax = "hierarq"
