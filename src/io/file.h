/* Whole files: reading with a size limit, writing through a temporary file, hashing, joining paths. */
#ifndef TY_IO_FILE_H
#define TY_IO_FILE_H

#include <tyndall/base.h>

#include <stdio.h>

/* Opens a regular file for reading; *size is its length. The caller closes it. NULL on failure, with the cause in
 * errno (0: not a regular file). */
FILE* ty_open_regular(const char* path, uint64_t* size);
/* Reads the first bytes of a regular file, at most size. Returns how many; 0 where there is no such file. */
size_t ty_read_head(const char* path, void* out, size_t size);
/* The same as ty_open_regular, with an error message. */
ty_result ty_open_file(ty_context* context, const char* path, FILE** stream, uint64_t* size);

/* True if there is a folder of this name. */
bool ty_is_folder(const char* path);

/* Reads a file of at most `limit` bytes and appends a zero byte; freed with ty_free_file. */
ty_result ty_read_file(ty_context* context, const char* path, size_t limit, uint8_t** bytes, size_t* size);
/* Reads `size` bytes from an offset on, or as many as there are, in the same way. */
ty_result ty_read_part(ty_context* context, const char* path, uint64_t offset, size_t limit, uint8_t** bytes,
                       size_t* size);

/* Form of a large file, by its first bytes. */
typedef struct ty_file_form {
    uint64_t longest; /* bytes that such a file may have; UINT64_MAX: any number */
    bool text;        /* there is no zero byte in it */
} ty_file_form;

/* Inspects the first bytes of a file, which end with a zero at head[size] and may be changed. *form is any file. Fails
 * if no file of the format begins so. */
typedef ty_result (*ty_file_form_fn)(ty_context* context, const char* path, uint8_t* head, size_t size,
                                     ty_file_form* form);

/* Bytes behind the content of a file that its form lets pass. Files that are no longer are read without being
 * inspected.
 */
#define TY_FILE_SLACK ((uint64_t)1 << 26)

/* As ty_read_file, but a file that is longer than its beginning allows, such as one that ends in nothing but zeros, is
 * refused before it is read. */
ty_result ty_read_inspected_file(ty_context* context, const char* path, size_t limit, ty_file_form_fn inspect,
                                 uint8_t** bytes, size_t* size);
void ty_free_file(ty_context* context, uint8_t* bytes, size_t size);

/* The one way to write a file: under a temporary name beside its target, which is made durable and renamed. A
 * successful open is followed by exactly one commit or discard. The target changes only in a commit that returns TY_OK;
 * both remove the temporary file. Interrupted calls and short writes are continued. The first failed write is kept in
 * `error`, later ones do nothing, and the commit reports it: encoders need no messages of their own. */
typedef struct ty_output {
    char* path;      /* target */
    char* temporary; /* file that descriptor writes */
    int descriptor;
    int error; /* errno of the first failed write, or 0 */
    uint8_t* buffer;
    size_t buffered; /* bytes in buffer */
    uint64_t offset; /* of the buffer's first byte in the file */
    int slot;        /* in the list of open outputs; -1: the list was full */
} ty_output;

ty_result ty_output_open(ty_context* context, const char* path, ty_output* output);
/* Appends bytes after those that were written last; false after the first error. */
bool ty_output_write(ty_output* output, const void* bytes, size_t size);
/* Writes bytes at an offset from the file's begin. */
bool ty_output_write_at(ty_output* output, const void* bytes, size_t size, uint64_t offset);
/* Offset of the byte after those that were written last. */
uint64_t ty_output_position(const ty_output* output);
ty_result ty_output_commit(ty_context* context, ty_output* output);
void ty_output_discard(ty_context* context, ty_output* output);
/* Removes the temporary files of all open outputs, for a process that ends at once: also a signal handler may do it. */
void ty_remove_unfinished_outputs(void);

/* Open, write and commit for content in memory. */
ty_result ty_write_file(ty_context* context, const char* path, const void* bytes, size_t size);

/* 64-bit FNV-1a hash; starts from TY_HASH_START and is chained through the result. */
#define TY_HASH_START 0xcbf29ce484222325ull
uint64_t ty_hash_bytes(uint64_t hash, const void* bytes, size_t size);
/* Extends *hash by a file's content. */
ty_result ty_hash_file(ty_context* context, const char* path, uint64_t* hash);

/* folder/relative, or relative alone if it is absolute or folder is empty; freed with ty_free_text. NULL if memory
 * runs out. */
char* ty_join_path(ty_context* context, const char* folder, const char* relative);
/* Folder part of a path: "" for a bare name, "/" for a name in the root. */
char* ty_folder_of(ty_context* context, const char* path);

#endif
