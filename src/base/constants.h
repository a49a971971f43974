/* Constants in double precision; kernels take TY_PI of base/kernel.h in single. */
#ifndef TY_BASE_CONSTANTS_H
#define TY_BASE_CONSTANTS_H

#define TY_PI_F64 3.14159265358979323846
#define TY_SQRT_4PI_F64 3.54490770181103205460 /* 1 / Y_0^0 */

#endif
