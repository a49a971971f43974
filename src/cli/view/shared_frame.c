#include "cli/view/shared_frame.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct view_shared_frame {
    atomic_int users;
    view_frame frame;
    view_codec codec;
    pthread_mutex_t encoding;
    float* rgb; /* until the message is made */
    uint8_t* message;
    size_t size;
};

view_shared_frame* view_shared_frame_create(const view_frame* frame, view_codec codec) {
    const size_t bytes = 3 * sizeof(float) * (size_t)frame->width * (size_t)frame->height;
    view_shared_frame* shared = calloc(1, sizeof *shared);
    float* rgb = malloc(bytes);
    if (shared == NULL || rgb == NULL || pthread_mutex_init(&shared->encoding, NULL) != 0) {
        free(shared);
        free(rgb);
        return NULL;
    }
    memcpy(rgb, frame->rgb, bytes);
    atomic_init(&shared->users, 1);
    shared->frame = *frame;
    shared->frame.rgb = rgb;
    shared->codec = codec;
    shared->rgb = rgb;
    return shared;
}

view_shared_frame* view_shared_frame_keep(view_shared_frame* shared) {
    if (shared != NULL) atomic_fetch_add(&shared->users, 1);
    return shared;
}

void view_shared_frame_release(view_shared_frame* shared) {
    if (shared == NULL || atomic_fetch_sub(&shared->users, 1) > 1) return;
    pthread_mutex_destroy(&shared->encoding);
    free(shared->rgb);
    free(shared->message);
    free(shared);
}

const uint8_t* view_shared_frame_message(view_shared_frame* shared, size_t* size) {
    pthread_mutex_lock(&shared->encoding);
    if (shared->message == NULL && view_frame_encode(&shared->frame, shared->codec, &shared->message, &shared->size)) {
        free(shared->rgb);
        shared->rgb = NULL;
    }
    pthread_mutex_unlock(&shared->encoding);
    *size = shared->size;
    return shared->message;
}
