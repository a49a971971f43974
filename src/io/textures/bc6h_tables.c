/* The published tables of BC6H. */
#include "io/textures/bc6h.h"

const uint16_t ty_bc6h_partitions[TY_BC6H_PARTITIONS] = {
    0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80,
    0xe800, 0xffe8, 0xff00, 0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310,
    0x3100, 0x8cce, 0x088c, 0x3110, 0x6666, 0x366c, 0x17e8, 0x0ff0, 0x718e, 0x399c};

const uint8_t ty_bc6h_anchors[TY_BC6H_PARTITIONS] = {15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15,
                                                     15, 2,  8,  2,  2,  8,  8,  15, 2,  8,  2,  2,  8,  8,  2,  2};

const int32_t ty_bc6h_weights[2][16] = {{0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64},
                                        {0, 9, 18, 27, 37, 46, 55, 64}};

/* A row of the tables "Endpoint and partition parameters" and "Block formats": fields by channel and endpoint, their
 * bits from the lowest of the block on. A range whose first bit is below its last, as the tables print them, is stored
 * from its last bit down. */
typedef struct mode_row {
    int32_t number;
    bool transformed;
    int32_t subsets, bits, delta[3];
    const char* fields;
} mode_row;

static const mode_row rows[TY_BC6H_MODES] = {
    {15, true, 1, 16, {4, 4, 4}, "r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10:15] g1[3:0] g0[10:15] b1[3:0] b0[10:15]"},
    {11, true, 1, 12, {8, 8, 8}, "r0[9:0] g0[9:0] b0[9:0] r1[7:0] r0[10:11] g1[7:0] g0[10:11] b1[7:0] b0[10:11]"},
    {7, true, 1, 11, {9, 9, 9}, "r0[9:0] g0[9:0] b0[9:0] r1[8:0] r0[10] g1[8:0] g0[10] b1[8:0] b0[10]"},
    {3, false, 1, 10, {10, 10, 10}, "r0[9:0] g0[9:0] b0[9:0] r1[9:0] g1[9:0] b1[9:0]"},
    {2,
     true,
     2,
     11,
     {5, 4, 4},
     "r0[9:0] g0[9:0] b0[9:0] r1[4:0] r0[10] g2[3:0] g1[3:0] g0[10] b3[0] g3[3:0] b1[3:0] b0[10] b3[1] b2[3:0] "
     "r2[4:0] b3[2] r3[4:0] b3[3]"},
    {6,
     true,
     2,
     11,
     {4, 5, 4},
     "r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10] g3[4] g2[3:0] g1[4:0] g0[10] g3[3:0] b1[3:0] b0[10] b3[1] b2[3:0] "
     "r2[3:0] b3[0] b3[2] r3[3:0] g2[4] b3[3]"},
    {10,
     true,
     2,
     11,
     {4, 4, 5},
     "r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10] b2[4] g2[3:0] g1[3:0] g0[10] b3[0] g3[3:0] b1[4:0] b0[10] b2[3:0] "
     "r2[3:0] b3[1] b3[2] r3[3:0] b3[4] b3[3]"},
    {0,
     true,
     2,
     10,
     {5, 5, 5},
     "g2[4] b2[4] b3[4] r0[9:0] g0[9:0] b0[9:0] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1] b2[3:0] "
     "r2[4:0] b3[2] r3[4:0] b3[3]"},
    {14,
     true,
     2,
     9,
     {5, 5, 5},
     "r0[8:0] b2[4] g0[8:0] g2[4] b0[8:0] b3[4] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1] b2[3:0] "
     "r2[4:0] b3[2] r3[4:0] b3[3]"},
    {18,
     true,
     2,
     8,
     {6, 5, 5},
     "r0[7:0] g3[4] b2[4] g0[7:0] b3[2] g2[4] b0[7:0] b3[3] b3[4] r1[5:0] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] "
     "b3[1] b2[3:0] r2[5:0] r3[5:0]"},
    {22,
     true,
     2,
     8,
     {5, 6, 5},
     "r0[7:0] b3[0] b2[4] g0[7:0] g2[5] g2[4] b0[7:0] g3[5] b3[4] r1[4:0] g3[4] g2[3:0] g1[5:0] g3[3:0] b1[4:0] "
     "b3[1] b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]"},
    {26,
     true,
     2,
     8,
     {5, 5, 6},
     "r0[7:0] b3[1] b2[4] g0[7:0] b2[5] g2[4] b0[7:0] b3[5] b3[4] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] "
     "b1[5:0] b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]"},
    {1,
     true,
     2,
     7,
     {6, 6, 6},
     "g2[5] g3[4] g3[5] r0[6:0] b3[0] b3[1] b2[4] g0[6:0] b2[5] b3[2] g2[4] b0[6:0] b3[3] b3[5] b3[4] r1[5:0] "
     "g2[3:0] g1[5:0] g3[3:0] b1[5:0] b2[3:0] r2[5:0] r3[5:0]"},
    {30,
     false,
     2,
     6,
     {6, 6, 6},
     "r0[5:0] g3[4] b3[0] b3[1] b2[4] g0[5:0] g2[5] b2[5] b3[2] g2[4] b0[5:0] g3[5] b3[3] b3[5] b3[4] r1[5:0] "
     "g2[3:0] g1[5:0] g3[3:0] b1[5:0] b2[3:0] r2[5:0] r3[5:0]"},
};

static int32_t read_number(const char** at) {
    int32_t value = 0;
    for (; **at >= '0' && **at <= '9'; ++*at) value = 10 * value + (**at - '0');
    return value;
}

static void take_fields(const char* at, ty_bc6h_mode* mode) {
    while (*at != '\0') {
        const int32_t channel = *at == 'r' ? 0 : *at == 'g' ? 1 : 2, field = 3 * (at[1] - '0') + channel;
        at += 3;
        const int32_t first = read_number(&at);
        int32_t last = first;
        if (*at == ':') {
            ++at;
            last = read_number(&at);
        }
        const int32_t low = first < last ? first : last, count = first < last ? last - first + 1 : first - last + 1;
        for (int32_t i = 0; i < count; ++i)
            mode->place[mode->places++] = (uint8_t)(16 * field + (first < last ? last - i : low + i));
        ++at; /* the bracket */
        if (*at == ' ') ++at;
    }
}

void ty_bc6h_fill_tables(ty_bc6h_tables* tables) {
    for (int32_t i = 0; i < TY_BC6H_MODES; ++i) {
        const mode_row* row = &rows[i];
        ty_bc6h_mode* mode = &tables->modes[i];
        *mode = (ty_bc6h_mode){.number = row->number,
                               .number_bits = row->number < 2 ? 2 : 5,
                               .transformed = row->transformed,
                               .subsets = row->subsets,
                               .bits = row->bits,
                               .delta = {row->delta[0], row->delta[1], row->delta[2]}};
        take_fields(row->fields, mode);
    }
}

int32_t ty_bc6h_unquantize(int32_t value, int32_t bits, bool with_sign) {
    const int32_t magnitude = value < 0 ? -value : value;
    int32_t wide;
    if (with_sign)
        wide = bits >= 16 || magnitude == 0         ? magnitude
               : magnitude >= (1 << (bits - 1)) - 1 ? 0x7fff
                                                    : ((magnitude << 15) + 0x4000) >> (bits - 1);
    else
        wide = bits >= 15 || magnitude == 0   ? magnitude
               : magnitude == (1 << bits) - 1 ? 0xffff
                                              : ((magnitude << 15) + 0x4000) >> (bits - 1);
    return value < 0 ? -wide : wide;
}
