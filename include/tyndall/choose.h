/* Tyndall: which method to trust with a scene. Apache-2.0.
 *
 * A look at what the camera sees, and rules that are in docs/method/auto.md with what they cost where they are wrong.
 */
#ifndef TYNDALL_CHOOSE_H
#define TYNDALL_CHOOSE_H

#include <tyndall/base.h>
#include <tyndall/path.h>
#include <tyndall/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What is asked for that path tracing alone can do. */
enum {
    TY_ASK_CROP = 1,    /* a part of the frame */
    TY_ASK_TIME = 2,    /* the best within some seconds */
    TY_ASK_ERROR = 4,   /* to go on until the error is below a bound */
    TY_ASK_RESUME = 8,  /* to go on later */
    TY_ASK_SAMPLES = 16 /* so many samples a pixel; other methods take them for surfaces alone */
};

/* What is asked of the picture. */
typedef struct ty_choose_def {
    uint32_t cookie; /* set by ty_default_choose_def; checked */
    uint32_t asks;   /* TY_ASK_... together; default 0 */
    uint32_t aovs;   /* TY_AOV_... together, the channels that are asked for; default 0 */
} ty_choose_def;

/* What a few hundred rays from the camera, and as many from what scatters in its view, find. 0 where there is none. */
typedef struct ty_scene_features {
    double media;     /* fraction of the frame in which there are media */
    double thickness; /* optical, along the ray that has most of it; mean of the channels */
    double opacity;   /* fraction of the light from behind that media take, mean over the frame */
    double g, albedo; /* of what scatters, weighted by what is seen of it; means of the channels */
    double cell; /* optical thickness, where media first scatter, of a fortieth of the longest side of the box around
                    them, about a cell of grid methods; mean over the view */
    double surfaces;    /* fraction of the frame in which there are surfaces */
    double enclosed;    /* of the directions around what scatters in view, the fraction in which there are surfaces no
                           farther off than the media's box is long */
    bool heterogeneous; /* whether media differ from place to place */
    bool glows;         /* whether media send light of their own */
    bool inside;        /* whether the camera is in a medium */
    uint32_t lights;    /* 1 << TY_LIGHT_... for each kind; glowing surfaces count as area lights */
} ty_scene_features;

/* What is chosen. */
typedef struct ty_choice {
    const char* method;         /* "path", "lpv" or "dom" */
    char reason[256];           /* why, as one sentence without its full stop: "uneven media ..." */
    ty_scene_features features; /* what was seen of the scene */
} ty_choice;

/* Nothing but a picture. */
TY_API ty_choose_def ty_default_choose_def(void);

/* Chooses for a committed scene, whose camera counts. What is chosen does not refuse the scene. It depends on nothing
 * but the scene and def. Errors: TY_ERROR_ARGUMENT (def, scene not committed), TY_ERROR_MEMORY. */
TY_API ty_result ty_choose_method(const ty_scene* scene, const ty_choose_def* def, ty_choice* out);

#ifdef __cplusplus
}
#endif
#endif
