/* The end of a program in which a C++ library throws where nobody can catch: in its own threads or destructors. */
#ifndef TY_CLI_SESSION_TERMINATE_H
#define TY_CLI_SESSION_TERMINATE_H

#ifdef __cplusplus
extern "C" {
#endif

/* From here on such an end is one line on stderr and the exit status 1, and no temporary file is left; an abort
 * otherwise. */
void cli_catch_termination(void);

#ifdef __cplusplus
}
#endif
#endif
