# cmake -DLIST=file -DOUTPUT=file.c -DNAME=array -P embed_scenes.cmake: LIST holds one scene file a line.
include("${CMAKE_CURRENT_LIST_DIR}/embed_bytes.cmake")
file(STRINGS "${LIST}" inputs)
list(TRANSFORM inputs REPLACE "\\.json$" "")
list(SORT inputs)
set(texts "")
set(rows "")
foreach(input IN LISTS inputs)
  get_filename_component(name "${input}" NAME)
  string(MAKE_C_IDENTIFIER "text_${name}" symbol)
  embed_bytes("${input}.json" bytes)
  string(APPEND texts "static const char ${symbol}[] = {\n    ${bytes}};\n\n")
  string(APPEND rows "    {\"${name}\", ${symbol}, sizeof ${symbol} - 1},\n")
endforeach()
file(WRITE "${OUTPUT}" "/* Made from scene files. */
#include \"io/scenes/builtin.h\"

#include <stddef.h>

${texts}extern const ty_builtin_scene ${NAME}[];
const ty_builtin_scene ${NAME}[] = {
${rows}    {NULL, NULL, 0},
};
")
