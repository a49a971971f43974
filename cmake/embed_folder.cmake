# cmake -DLIST=file -DOUTPUT=file.c -DHEADER=file.h -DTYPE=type -DNAME=array -P embed_folder.cmake: LIST holds one file a
# line; TYPE has its name, text and size.
include("${CMAKE_CURRENT_LIST_DIR}/embed_bytes.cmake")
file(STRINGS "${LIST}" inputs)
list(SORT inputs)
set(texts "")
set(rows "")
foreach(input IN LISTS inputs)
  get_filename_component(name "${input}" NAME)
  string(MAKE_C_IDENTIFIER "text_${name}" symbol)
  embed_bytes("${input}" bytes)
  string(APPEND texts "static const char ${symbol}[] = {\n    ${bytes}};\n\n")
  string(APPEND rows "    {\"${name}\", ${symbol}, sizeof ${symbol} - 1},\n")
endforeach()
file(WRITE "${OUTPUT}" "/* Made from the files of a folder. */
#include \"${HEADER}\"

#include <stddef.h>

${texts}const ${TYPE} ${NAME}[] = {
${rows}    {NULL, NULL, 0},
};
")
