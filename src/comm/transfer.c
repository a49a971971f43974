/* Transfers between ranks that know what comes, and calls of all ranks made of them. */
#include "comm/state.h"

#include "base/context.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>

/* Looks for the end of a transfer before the thread sleeps, and its shortest and longest sleep, seconds. */
enum { LOOKS = 40 };
static const double nap_shortest = 2e-5, nap_longest = 5e-4;
/* Tag of transfers that all ranks make. */
enum { TAG_OF_ALL = TY_COMM_TAGS };

/* ---- between two ranks ---- */

static bool lose(ty_comm* comm, int32_t rank) {
    if (comm->lost < 0) comm->lost = rank;
    return false;
}

int32_t ty_comm_lost(const ty_comm* comm) {
    return comm != NULL ? comm->lost : -1;
}

bool ty_comm_post(ty_comm* comm, ty_comm_transfer* transfers, int32_t count) {
    for (int32_t i = 0; i < count; ++i) {
        ty_comm_transfer* t = &transfers[i];
        t->done = false;
        if (comm->lost >= 0) return false;
        pthread_mutex_lock(&comm->lock);
        const bool posted = comm->backend->post(t);
        if (posted) ty_comm_count_message(comm, t->size);
        pthread_mutex_unlock(&comm->lock);
        if (!posted) return lose(comm, t->rank);
    }
    return true;
}

static bool test(ty_comm* comm, ty_comm_transfer* t) {
    if (t->done) return true;
    pthread_mutex_lock(&comm->lock);
    const bool good = comm->backend->test(t);
    pthread_mutex_unlock(&comm->lock);
    return good || lose(comm, t->rank);
}

bool ty_comm_is_done(ty_comm* comm, ty_comm_transfer* transfer) {
    return comm->lost < 0 && test(comm, transfer) && transfer->done;
}

/* Frees copies that have been sent. */
static void sweep_copies(ty_comm* comm) {
    for (ty_comm_copy** at = &comm->copies; *at != NULL;) {
        ty_comm_copy* copy = *at;
        if (!test(comm, &copy->transfer)) return;
        if (!copy->transfer.done) {
            at = &copy->next;
            continue;
        }
        *at = copy->next;
        free(copy);
    }
}

/* A pause between two looks: the first ones only let other threads run. */
static void take_nap(int* looks, double* nap) {
    if (++*looks <= LOOKS) {
        sched_yield();
        return;
    }
    ty_comm_sleep(*nap);
    if (*nap < nap_longest) *nap *= 2;
}

bool ty_comm_finish(ty_comm* comm, ty_comm_transfer* transfers, int32_t count) {
    if (count == 0) return true;
    double begun = 0, nap = nap_shortest;
    int looks = 0;
    for (int32_t left = count; comm->lost < 0;) {
        int32_t waiting = 0;
        for (int32_t i = 0; i < count; ++i) {
            if (!test(comm, &transfers[i])) return false;
            waiting += !transfers[i].done;
        }
        if (waiting == 0) return true;
        if (waiting < left) looks = 0;
        left = waiting;
        if (looks == LOOKS) begun = ty_wall_seconds();
        take_nap(&looks, &nap);
        if (looks <= LOOKS || ty_wall_seconds() - begun < comm->patience) continue;
        for (int32_t i = 0; i < count; ++i)
            if (!transfers[i].done) return lose(comm, transfers[i].rank);
    }
    return false;
}

bool ty_comm_put(ty_comm* comm, int32_t to, int32_t tag, const void* bytes, size_t size) {
    sweep_copies(comm);
    ty_comm_copy* copy = malloc(sizeof *copy + size);
    if (copy == NULL) return lose(comm, comm->rank);
    *copy = (ty_comm_copy){{.rank = to, .tag = tag, .bytes = copy + 1, .size = size}, comm->copies};
    if (size > 0) memcpy(copy + 1, bytes, size);
    if (!ty_comm_post(comm, &copy->transfer, 1)) {
        free(copy);
        return false;
    }
    comm->copies = copy;
    return true;
}

bool ty_comm_get(ty_comm* comm, int32_t from, int32_t tag, void* bytes, size_t size) {
    ty_comm_transfer t = {.rank = from, .tag = tag, .bytes = bytes, .size = size, .receives = true};
    return ty_comm_post(comm, &t, 1) && ty_comm_finish(comm, &t, 1);
}

void ty_comm_end_puts(ty_comm* comm, bool wait) {
    while (comm->copies != NULL) {
        ty_comm_copy* copy = comm->copies;
        if (wait) ty_comm_finish(comm, &copy->transfer, 1);
        comm->copies = copy->next;
        free(copy);
    }
}

/* ---- of all ranks ---- */

bool ty_comm_move(ty_comm* comm, int32_t rank, bool receives, void* bytes, size_t size) {
    for (size_t at = 0; at < size; at += TY_COMM_TRANSFER_MAX) {
        const size_t left = size - at, piece = left < TY_COMM_TRANSFER_MAX ? left : TY_COMM_TRANSFER_MAX;
        ty_comm_transfer t = {
            .rank = rank, .tag = TAG_OF_ALL, .bytes = (char*)bytes + at, .size = piece, .receives = receives};
        if (!ty_comm_post(comm, &t, 1) || !ty_comm_finish(comm, &t, 1)) return false;
    }
    return true;
}

bool ty_comm_gather(ty_comm* comm, void* all, const size_t* offsets) {
    if (comm == NULL) return true;
    char* bytes = all;
    if (comm->rank > 0)
        return ty_comm_move(comm, 0, false, bytes + offsets[comm->rank], offsets[comm->rank + 1] - offsets[comm->rank]);
    for (int32_t r = 1; r < comm->size; ++r)
        if (!ty_comm_move(comm, r, true, bytes + offsets[r], offsets[r + 1] - offsets[r])) return false;
    return true;
}

/* Down a binomial tree, whose root is rank 0: rank r has what came to it from r less its lowest bit. */
bool ty_comm_broadcast(ty_comm* comm, void* bytes, size_t size) {
    if (comm == NULL) return true;
    int32_t bit = 1;
    while (bit < comm->size && (comm->rank & bit) == 0) bit <<= 1;
    if (comm->rank > 0 && !ty_comm_move(comm, comm->rank - bit, true, bytes, size)) return false;
    for (bit >>= 1; bit > 0; bit >>= 1)
        if (comm->rank + bit < comm->size && !ty_comm_move(comm, comm->rank + bit, false, bytes, size)) return false;
    return true;
}

/* Transfers of the parts of ranks first, first + 1, ... (count of them, from rank 0 on again after the last one): one,
 * or two where they are in two pieces. Returns their number. */
static int32_t parts(const ty_comm* comm, char* all, const size_t* offsets, int32_t first, int32_t count,
                     ty_comm_transfer kind, ty_comm_transfer* out) {
    const int32_t end = first + count < comm->size ? first + count : comm->size, over = first + count - end;
    const int32_t ranges[2][2] = {{first, end}, {0, over}};
    int32_t made = 0;
    for (int i = 0; i < 2; ++i) {
        const size_t begin = offsets[ranges[i][0]], size = offsets[ranges[i][1]] - begin;
        if (size == 0) continue;
        out[made] = kind;
        out[made].bytes = all + begin;
        out[made++].size = size;
    }
    return made;
}

/* The algorithm of Bruck et al. (1997): in step k a rank has the parts of 2^k ranks from itself on, and gets those of
 * the next 2^k. */
bool ty_comm_gather_all(ty_comm* comm, void* all, const size_t* offsets) {
    if (comm == NULL) return true;
    for (int32_t had = 1; had < comm->size; had *= 2) {
        const int32_t from = (comm->rank + had) % comm->size, to = (comm->rank - had + comm->size) % comm->size;
        const int32_t count = had < comm->size - had ? had : comm->size - had;
        ty_comm_transfer transfers[4];
        int32_t made = parts(comm, all, offsets, from, count,
                             (ty_comm_transfer){.rank = from, .tag = TAG_OF_ALL, .receives = true}, transfers);
        made += parts(comm, all, offsets, comm->rank, count, (ty_comm_transfer){.rank = to, .tag = TAG_OF_ALL},
                      transfers + made);
        if (!ty_comm_post(comm, transfers, made) || !ty_comm_finish(comm, transfers, made)) return false;
    }
    return true;
}

/* Brings the values of all ranks together, and combines them in the order of ranks. */
static bool combine(ty_comm* comm, double* values, int32_t count, bool max) {
    if (comm == NULL) return true;
    const size_t ranks = (size_t)comm->size, items = (size_t)count;
    double* all = malloc(sizeof(double) * ranks * items + sizeof(size_t) * (ranks + 1));
    if (all == NULL) return lose(comm, comm->rank);
    size_t* offsets = (size_t*)(all + ranks * items);
    for (size_t r = 0; r <= ranks; ++r) offsets[r] = sizeof(double) * items * r;
    memcpy(all + items * (size_t)comm->rank, values, sizeof(double) * items);
    const bool good = ty_comm_gather_all(comm, all, offsets);
    for (size_t i = 0; i < items && good; ++i) {
        values[i] = all[i];
        for (size_t r = 1; r < ranks; ++r) {
            const double other = all[r * items + i];
            values[i] = !max ? values[i] + other : other > values[i] ? other : values[i];
        }
    }
    free(all);
    return good;
}

bool ty_comm_sum(ty_comm* comm, double* values, int32_t count) {
    return combine(comm, values, count, false);
}

bool ty_comm_max(ty_comm* comm, double* values, int32_t count) {
    return combine(comm, values, count, true);
}
