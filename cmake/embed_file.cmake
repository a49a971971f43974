# cmake -DINPUT=file -DOUTPUT=file.c -DNAME=name -P embed_file.cmake
include("${CMAKE_CURRENT_LIST_DIR}/embed_bytes.cmake")
embed_bytes("${INPUT}" bytes)
get_filename_component(input_name "${INPUT}" NAME)
file(WRITE "${OUTPUT}" "/* Made from ${input_name}. */
extern const char ${NAME}_text[];
extern const unsigned ${NAME}_size;

const char ${NAME}_text[] = {
    ${bytes}};
const unsigned ${NAME}_size = sizeof ${NAME}_text - 1;
")
