/* Frames of the viewer as binary messages (docs/view_protocol.md). Only frame.c includes turbojpeg. */
#ifndef TY_CLI_VIEW_FRAME_H
#define TY_CLI_VIEW_FRAME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum view_channel { VIEW_CHANNEL_METHOD, VIEW_CHANNEL_PATH, VIEW_CHANNEL_COUNT } view_channel;
typedef enum view_codec { VIEW_CODEC_HALF, VIEW_CODEC_DEFLATE, VIEW_CODEC_JPEG } view_codec;

enum { VIEW_HEADER_BYTES = 64 };

typedef struct view_frame {
    view_channel channel;
    uint32_t revision;
    int32_t width, height;           /* pixels of rgb */
    int32_t full_width, full_height; /* pixels of the frame at full quality */
    const float* rgb;                /* linear radiance, 3 per pixel, rows from the top */
    float spp, latency, exposure;    /* latency: ms */
    bool final, moving;              /* moving: a coarse image on the way to others */
} view_frame;

/* Encodes a frame into a message with a header whose sequence is 0. *bytes is freed with free(). Values beyond half
 * floats are clamped to their range, and those that are not finite are 0. Returns false without memory. */
bool view_frame_encode(const view_frame* frame, view_codec codec, uint8_t** bytes, size_t* size);
/* Writes a sequence number into an encoded message. */
void view_frame_number(uint8_t* bytes, uint32_t sequence);

#endif
