/* A frame that several clients are sent: copied once, encoded once, freed with its last user. */
#ifndef TY_CLI_VIEW_SHARED_FRAME_H
#define TY_CLI_VIEW_SHARED_FRAME_H

#include "cli/view/frame.h"

typedef struct view_shared_frame view_shared_frame;

/* Copies a frame, for one user. Returns NULL without memory. */
view_shared_frame* view_shared_frame_create(const view_frame* frame, view_codec codec);
view_shared_frame* view_shared_frame_keep(view_shared_frame* shared);
/* NULL is allowed. */
void view_shared_frame_release(view_shared_frame* shared);
/* The message, which the first caller encodes and others wait for; valid until the release. NULL without memory. */
const uint8_t* view_shared_frame_message(view_shared_frame* shared, size_t* size);

#endif
