/* The list of all methods that render scenes, one line per method. */
#ifndef TY_METHOD_REGISTRY_H
#define TY_METHOD_REGISTRY_H

#include "method/method.h"

/* Each X(NAME) stands for a ty_method called ty_method_NAME, which the method's own folder defines. */
#define TY_METHOD_LIST(X)                                                                                              \
    X(path)                                                                                                            \
    X(screen)                                                                                                          \
    X(fld)                                                                                                             \
    X(cda)                                                                                                             \
    X(pop)                                                                                                             \
    X(lpv)                                                                                                             \
    X(dom)                                                                                                             \
    X(octaves)

#define TY_METHOD_DECLARE(name) extern const ty_method ty_method_##name;
TY_METHOD_LIST(TY_METHOD_DECLARE)
#undef TY_METHOD_DECLARE

#endif
