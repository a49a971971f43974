/* Inflating of deflated data in memory: gzip and zlib streams, and bare deflate. */
#ifndef TY_IO_INFLATE_H
#define TY_IO_INFLATE_H

#include <tyndall/base.h>

/* Maximum compression ratio of deflate. */
enum { TY_INFLATE_RATIO_MAX = 1032 };

typedef enum ty_inflated {
    TY_INFLATED_WHOLE,  /* all streams ended, and their data ends where `to` does */
    TY_INFLATED_SHORT,  /* all streams ended, with less data */
    TY_INFLATED_MORE,   /* `to` is full, and more data follows */
    TY_INFLATED_DAMAGED /* a stream is damaged or cut short, or memory ran out */
} ty_inflated;

/* Inflates one or several gzip (or zlib) streams; the first `skip` bytes of their data are left out. *got is the size
 * of the data, those bytes included, as far as it was inflated. */
ty_inflated ty_inflate_gzip(const uint8_t* from, size_t from_size, uint64_t skip, uint8_t* to, size_t to_size,
                            uint64_t* got);
/* Inflates bare deflate data of unknown length into an array of at most `limit` bytes with a zero after them, which is
 * freed with ty_free_file. Fails with TY_ERROR_INPUT if it is damaged or longer; `path` is for messages. */
ty_result ty_inflate_bare(ty_context* context, const char* path, const uint8_t* from, size_t from_size, size_t limit,
                          uint8_t** to, size_t* to_size);

#endif
