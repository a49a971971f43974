/* Cells of a grid from one way to share them among ranks to another. */
#ifndef TY_COMM_REGROUP_H
#define TY_COMM_REGROUP_H

#include "comm/domain.h"

/* Moves items of cells, from where they are by `from` to where they are by `to`, domains of one grid; NULL stands for
 * rank 0, which has all cells. in, out: the first cell of this rank's box on each side; unused where it has none. A
 * call of all ranks. False: a rank does not answer. */
bool ty_domain_regroup(ty_comm* comm, const ty_domain* from, const ty_domain* to, const ty_halo* in,
                       const ty_halo* out);
/* Bytes that a call moves between ranks, all of them together, of items of one byte. */
uint64_t ty_domain_regroup_bytes(int32_t ranks, const ty_domain* from, const ty_domain* to);

#endif
