/* BC6H: blocks of 4 x 4 texels of three half floats in 16 bytes (Khronos Data Format Specification 1.3, "BC6H"). */
#ifndef TY_IO_TEXTURES_BC6H_H
#define TY_IO_TEXTURES_BC6H_H

#include <tyndall/base.h>

enum {
    TY_BC6H_MODES = 14,
    TY_BC6H_PLACES = 77,     /* bits of a mode's number and endpoints, at most */
    TY_BC6H_PARTITIONS = 32, /* ways of dividing a block into two subsets */
    TY_BC6H_BLOCK_BYTES = 16
};

/* One mode: the precision of the endpoints, and where their bits lie. Endpoint 0 is stored as it is; where endpoints
 * are transformed, the others are differences from it, of fewer bits. */
typedef struct ty_bc6h_mode {
    int32_t number, number_bits; /* what the first bits of a block hold */
    bool transformed;
    int32_t subsets;               /* 1, with indices of 4 bits, or 2, with indices of 3 bits */
    int32_t bits;                  /* of endpoint 0 */
    int32_t delta[3];              /* bits of the other endpoints, per channel */
    int32_t places;                /* number of bits of all endpoints */
    uint8_t place[TY_BC6H_PLACES]; /* of each bit behind the number: 16 (3 endpoint + channel) + bit of that value */
} ty_bc6h_mode;

/* The format's modes: those of one subset, then those of two, each by falling precision. */
typedef struct ty_bc6h_tables {
    ty_bc6h_mode modes[TY_BC6H_MODES];
} ty_bc6h_tables;

/* Texels that belong to subset 1, a bit each, row by row from the top left ("Partition table for BPTC 2 subset"). */
extern const uint16_t ty_bc6h_partitions[TY_BC6H_PARTITIONS];
/* The texel of subset 1 whose index has one bit less ("BPTC anchor index values for the second subset"). */
extern const uint8_t ty_bc6h_anchors[TY_BC6H_PARTITIONS];
/* The share of the second endpoint by index, in 64ths, of 16 and of 8 indices. */
extern const int32_t ty_bc6h_weights[2][16];

void ty_bc6h_fill_tables(ty_bc6h_tables* tables);

/* The value between 0 and 65535, with signs -32767 and 32767, that an endpoint of so many bits stands for. */
int32_t ty_bc6h_unquantize(int32_t value, int32_t bits, bool with_sign);

/* A slice to be encoded. */
typedef struct ty_bc6h_request {
    const ty_bc6h_tables* tables;
    const uint16_t* halves; /* width x height x 3, finite */
    uint8_t* blocks;        /* TY_BC6H_BLOCK_BYTES each, row by row */
    int32_t width, height;  /* texels; those past an edge repeat it */
    bool with_sign;         /* the format with signs; without, values below 0 become 0 */
    uint32_t modes;         /* bit i: modes[i] may be used; blocks that none of them holds become 0 */
} ty_bc6h_request;

/* Encodes the blocks of one row of blocks. */
void ty_bc6h_encode_row(const ty_bc6h_request* request, int32_t row);

#endif
