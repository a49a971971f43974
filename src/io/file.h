/* Whole files: reading with a cap, writing through a temporary name, hashing, joining paths. */
#ifndef TY_IO_FILE_H
#define TY_IO_FILE_H

#include <tyndall/base.h>

#include <stdio.h>

/* Opens a regular file for reading; *size is its length. The caller closes it. NULL leaves the cause in errno, 0 for
 * what is not a regular file. */
FILE* ty_open_regular(const char* path, uint64_t* size);
/* The same with a message. */
ty_result ty_open_file(ty_context* context, const char* path, FILE** stream, uint64_t* size);

/* The bytes of a file and a zero after them; freed with ty_free_file. A file of more than limit bytes is refused. */
ty_result ty_read_file(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size);
void ty_free_file(ty_context* context, uint8_t* bytes, size_t size);

/* A file being written beside its target. Exactly one of commit and discard follows a successful open; the target
 * changes only in a commit that returns TY_OK, and the temporary file is gone after either. */
typedef struct ty_output {
    FILE* stream;    /* open for writing */
    char* path;      /* the target */
    char* temporary; /* where stream writes */
} ty_output;

ty_result ty_output_open(ty_context* context, const char* path, ty_output* output);
ty_result ty_output_commit(ty_context* context, ty_output* output);
void ty_output_discard(ty_context* context, ty_output* output);

/* All three steps for content that is in memory. */
ty_result ty_write_file(ty_context* context, const char* path, const void* bytes, size_t size);

/* 64-bit FNV-1a; begin with TY_HASH_START and pass each result on. */
#define TY_HASH_START 0xcbf29ce484222325ull
uint64_t ty_hash_bytes(uint64_t hash, const void* bytes, size_t size);
/* Hashes a file's content on top of *hash. */
ty_result ty_hash_file(ty_context* context, const char* path, uint64_t* hash);

/* folder/relative, or relative alone when it is absolute or folder is empty; freed with ty_free_text. NULL when
 * memory is short. */
char* ty_join_path(ty_context* context, const char* folder, const char* relative);
/* The folder part of a path: "" for a bare name, "/" for a name in the root. */
char* ty_folder_of(ty_context* context, const char* path);

#endif
