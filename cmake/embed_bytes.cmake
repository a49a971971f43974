# embed_bytes(FILE RESULT): the file as the elements of a char array, NUL-terminated, without braces.
function(embed_bytes file result)
  file(READ "${file}" hex HEX)
  string(REPEAT "." 32 line)
  string(REGEX REPLACE "(${line})" "\\1\n    " hex "${hex}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
  set(${result} "${bytes}0" PARENT_SCOPE)
endfunction()
