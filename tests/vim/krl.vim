" Says how Vim's own syntax and indentation for KRL take the files that it is given as arguments.
"
" A line for each run of characters of one syntax group: FILE, LINE, COLUMN, GROUP, TEXT, with tabs between. FILE is
" the number of the argument. A line that Vim would indent otherwise is said once more, under the group INDENT.

let s:said = []

" Where a group can begin: at a word, at blanks, at any other character.
let s:piece = '\w\+\|\s\+\|[^0-9A-Za-z_[:blank:]]'

function s:Runs(file, number) abort
  let text = getline(a:number)
  let start = 0
  let before = -1
  let at = 0
  while at < len(text)
    let end = matchend(text, '^\%(' .. s:piece .. '\)', at)
    let end = end > at ? end : at + 1
    let group = synID(a:number, at + 1, 0)
    if group != before && at > 0
      call s:Say(a:file, a:number, start, before, text[start : at - 1])
      let start = at
    endif
    let before = group
    let at = end
  endwhile
  if len(text) > 0
    call s:Say(a:file, a:number, start, before, text[start : ])
  endif
endfunction

function s:Say(file, number, start, group, text) abort
  call add(s:said, join([a:file, a:number, a:start + 1, synIDattr(a:group, 'name'), a:text], "\t"))
endfunction

function s:Indent(file) abort
  let before = getline(1, '$')
  silent! normal! gg=G
  for number in range(1, len(before))
    if getline(number) !=# before[number - 1]
      call add(s:said, join([a:file, number, 1, 'INDENT', getline(number)], "\t"))
    endif
  endfor
endfunction

" The older engine of regular expressions reads these some ten times faster.
set regexpengine=1
syntax on
filetype indent on
for s:file in range(argc())
  execute 'edit!' fnameescape(argv(s:file))
  set filetype=krl
  syntax sync fromstart
  for s:number in range(1, line('$'))
    call s:Runs(s:file, s:number)
  endfor
  call s:Indent(s:file)
endfor
call writefile(s:said, $KRL_SAID)
qall!
