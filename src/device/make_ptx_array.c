/* A program of the build: make_ptx_array NAME OUTPUT.c [NAME.ptx] writes ty_ptx_NAME, the deflated PTX of a program, or
 * an empty one. */
#include <stdio.h>
#include <stdlib.h>
#include <zlib.h>

static unsigned char* read_file(const char* path, size_t* size) {
    FILE* file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) return NULL;
    const long length = ftell(file);
    unsigned char* bytes = length > 0 ? malloc((size_t)length) : NULL;
    rewind(file);
    *size = bytes != NULL ? fread(bytes, 1, (size_t)length, file) : 0;
    fclose(file);
    return bytes != NULL && *size == (size_t)length ? bytes : NULL;
}

static int write_array(FILE* out, const char* name, const unsigned char* text, size_t size) {
    uLongf packed = compressBound((uLong)size);
    unsigned char* bytes = malloc(packed);
    if (bytes == NULL || compress2(bytes, &packed, text, (uLong)size, 9) != Z_OK) return 1;
    fprintf(out, "static const unsigned char bytes[] = {");
    for (uLongf i = 0; i < packed; ++i) fprintf(out, "%s%d,", i % 24 == 0 ? "\n    " : "", bytes[i]);
    fprintf(out, "\n};\nconst ty_ptx ty_ptx_%s = {bytes, sizeof bytes, %zu};\n", name, size);
    free(bytes);
    return 0;
}

int main(int count, char** arguments) {
    if (count != 3 && count != 4) return 2;
    size_t size = 0;
    unsigned char* text = count == 4 ? read_file(arguments[3], &size) : NULL;
    FILE* out = fopen(arguments[2], "w");
    if (out == NULL || (count == 4 && text == NULL)) return 1;
    fprintf(out, "#include \"device/program.h\"\n\nextern const ty_ptx ty_ptx_%s;\n", arguments[1]);
    int failed = 0;
    if (text != NULL)
        failed = write_array(out, arguments[1], text, size);
    else
        fprintf(out, "const ty_ptx ty_ptx_%s = {NULL, 0, 0};\n", arguments[1]);
    free(text);
    return fclose(out) != 0 || failed;
}
