/* State of a ty_comm, of which messages and transfers are the two parts. */
#ifndef TY_COMM_STATE_H
#define TY_COMM_STATE_H

#include "comm/comm.h"

#include <pthread.h>

/* A message of ty_comm_put under way; its bytes follow. */
typedef struct ty_comm_copy {
    ty_comm_transfer transfer;
    struct ty_comm_copy* next;
} ty_comm_copy;

struct ty_comm {
    const ty_comm_backend* backend;
    int32_t rank, size;
    pthread_mutex_t lock; /* of the backend's calls */
    ty_comm_traffic traffic;
    double patience; /* seconds that a transfer may take */
    int32_t lost;    /* rank that did not answer, or -1 */
    ty_comm_copy* copies;
};

void ty_comm_sleep(double seconds);
/* Under the lock. */
void ty_comm_count_message(ty_comm* comm, size_t size);
/* Frees the copies of ty_comm_put; wait: once they have arrived. */
void ty_comm_end_puts(ty_comm* comm, bool wait);

#endif
