/* The state of live rendering, for its own files. */
#ifndef TY_CLI_VIEW_LIVE_STATE_H
#define TY_CLI_VIEW_LIVE_STATE_H

#include "cli/view/accumulate.h"
#include "cli/view/live.h"
#include "cli/view/requests.h"
#include "io/scenes/scene_editor.h"
#include "method/registry.h"

#include <pthread.h>
#include <stdatomic.h>

/* The quality of the image of the present revision that clients were last shown. */
typedef enum view_shown { VIEW_SHOWN_NOTHING, VIEW_SHOWN_COARSE, VIEW_SHOWN_FULL } view_shown;

/* The last full image of a channel, for files. */
typedef struct view_picture {
    int32_t width, height;
    float* rgb; /* NULL: none yet */
    uint32_t revision;
    double spp;
    char method[16];
} view_picture;

enum { VIEW_STAGES_MAX = 24 };

typedef struct view_times {
    double load, solve, view, surfaces, latency; /* ms */
    int32_t count;
    struct {
        const char* name; /* "direct" */
        double ms;
    } stages[VIEW_STAGES_MAX];
} view_times;

/* The light of a method. */
typedef struct view_light {
    bool solved;
    void* media;           /* of the method; NULL where all media fill dielectrics, which surfaces show */
    ty_enclosed* enclosed; /* of media in dielectrics; NULL: none */
} view_light;

/* The source of images: a document that clients change, and the methods of rendering it. */
typedef struct view_source {
    const char* kind;      /* in the welcome: "scene" */
    const char* reference; /* what the second channel shows: "path" */
    bool own_size;         /* clients cannot change the frame's size */
    /* Changes the document, or else leaves it as it was; *edited stays 0 where nothing is another than before. */
    ty_result (*apply)(view_live* live, const ty_scene_change* changes, int32_t count, uint32_t* edited);
    /* Takes over what `apply` changed; edited: its flags. */
    void (*take)(view_live* live, uint32_t edited);
    /* False for an unknown name. */
    bool (*set_method)(view_live* live, const char* name);
    /* As view_live_step. */
    bool (*step)(view_live* live);
    const char* (*text)(const view_live* live); /* the document as compact JSON */
    /* Add members to the view, and to the welcome; `describe` is called under the mutex, by any thread. */
    void (*describe_view)(const view_live* live, json_t* view);
    void (*describe)(const view_live* live, json_t* welcome);
    /* The part that clients keep, as JSON text, and the command that makes the image; freed with free(). */
    ty_result (*save)(view_live* live, char** json, char** command);
    void (*close)(view_live* live); /* after a failed opening, too */
} view_source;

struct view_live {
    const view_source* source;
    ty_context* context;
    ty_scene_editor* editor;
    view_server* server;
    char name[256];         /* of the scene's file */
    const char* scene_path; /* as given */
    ty_axis up_axis;
    const char* record;
    bool remote;
    double meters_per_unit;

    /* Shared with the server's threads, under `mutex`. */
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    view_request *first, *last;
    char* original; /* the scene as compact JSON, as it was opened */
    char* document; /* and as it is */
    char* view;     /* the view as JSON */
    uint32_t document_revision;
    double extent[2][3];
    view_picture pictures[VIEW_CHANNEL_COUNT];
    bool newcomer; /* a client has connected that has not been shown anything */
    atomic_bool stop;
    atomic_bool interrupted; /* a request waits, or the end: the running work gives up */

    /* Of the rendering thread alone. */
    pthread_t thread;
    bool running;
    const ty_scene* scene;
    const ty_method* method;
    bool automatic;                          /* the method is chosen anew when lights, media or surfaces change */
    bool choice_due;                         /* once nothing moves any more */
    double expected_error, expected_seconds; /* of the choice; 0: none */
    bool compare, paused;
    int32_t width, height;
    double exposure;
    ty_tone_curve curve; /* of PNG files, and at first of the page */
    uint32_t revision;
    bool rested;     /* nothing was left to do for a while */
    double moved;    /* s: time of the last request that said that more follow; 0: at rest */
    double received; /* s: of the oldest request that the next image answers */

    const ty_method* light_method;
    view_light lights[TY_SOLVE_QUALITIES];     /* of light_method, by quality */
    double solve_seconds[TY_SOLVE_QUALITIES];  /* the last solve took; 0: none yet */
    double coarse_seconds[TY_SOLVE_QUALITIES]; /* the last coarse view of the light took; 0: none yet */
    double coarse_pixels[TY_SOLVE_QUALITIES];  /* that such a view has time for; 0: unknown */
    double view_seconds;                       /* a view at full size takes; 0: unknown */
    double surface_seconds;                    /* a first pass over the surfaces at full size takes; 0: unknown */
    double view_power;                         /* of the divisor of its sides by which an image takes less */
    view_shown shown;
    bool has_surfaces;
    view_photo* photo;          /* NULL: a scene */
    bool photo_shown;           /* as the second channel */
    bool failed;                /* the method refused the scene: nothing is shown until it changes */
    view_accumulation surfaces; /* light of surfaces alone, for methods that need it */
    view_accumulation path;     /* the reference, of path_revision */
    uint32_t path_revision;
    double path_seconds; /* estimate of its first pass at full size */
    bool path_next;      /* the next step is path's, while surfaces converge */
    float* rgb;          /* pixels of the last image, interleaved */
    size_t rgb_capacity; /* values */
    float* media;        /* pixels of the last view of media, interleaved, without the surfaces' own light */
    size_t media_capacity;
    cli_tev* tev;    /* NULL: none */
    float* enlarged; /* the last coarse image for tev */
    size_t enlarged_capacity;
    view_difference difference;
    bool has_difference;
    double shown_times[32]; /* s: of the last images, a ring, for the rate */
    uint32_t shown_count;
    view_times times;
    char message[512];
    const char* stage;
    double fraction;
    double told; /* s: time of the last status */
};

/* ---- scene_source.c ---- */

/* Sets the source, its method and the size of the frame. CLI_GO, or an exit status after a message. */
int view_open_scene(view_live* live, const view_live_def* def);

/* ---- photo_source.c ---- */

/* The same for a photograph. */
int view_open_photo(view_live* live, const view_live_def* def);

/* ---- steps.c ---- */

/* Does the next piece of work: a coarse image, a solve, the full image, a better image of the surfaces, a pass of path.
 * Returns false when nothing is left to do. */
bool view_live_step(view_live* live);
/* The same for a scene. */
bool view_step_scene(view_live* live);
/* Makes a choice of method auto that a drag put off. */
void view_choose_again(view_live* live);
/* The same by `render`: makes an image with the sides of the frame divided, and its stats. */
typedef ty_result (*view_render_fn)(view_live* live, int32_t divisor, ty_image** out, ty_method_run* run);
bool view_step_render(view_live* live, view_render_fn render);
/* A ty_progress_fn; user: the view_live. While something moves, changes do not interrupt its first image: they come
 * faster than images, and none would ever be shown. */
bool view_report(void* user, const ty_progress* progress);
/* True if the method's view shows media alone, and the surfaces' own light is added to it. */
bool view_adds_surfaces(const view_live* live);
/* True if there is light of the present method in a quality. */
bool view_has_light(const view_live* live, ty_solve_quality quality);
/* Frees light and sums. */
void view_live_drop_light(view_live* live);

/* ---- coarse.c ---- */

enum { VIEW_COARSE_SPACING = 2 };        /* pixels between the rays of coarse images */
extern const double view_coarse_seconds; /* a view is aimed to take while something moves */

/* Forgets all times, for another method. */
void view_coarse_forget(view_live* live);
/* The light for a coarse image, which may have to be solved. */
ty_solve_quality view_coarse_quality(view_live* live);
/* The divisor of both sides of a coarse image, 1..8. */
double view_coarse_divisor(const view_live* live, ty_solve_quality quality);
/* Learns from a coarse view, to which a first pass over the surfaces comes. */
void view_coarse_note(view_live* live, ty_solve_quality quality, double pixels, double seconds);

/* ---- show.c ---- */

/* Makes room for 3 values per pixel; NULL without memory. */
float* view_make_room(float** pixels, size_t* capacity, int32_t width, int32_t height);
/* Copies the planes R, G, B of an image, interleaved. Returns false if it has none. */
bool view_interleave(const ty_image* image, float* rgb);
/* Room for an image, 3 values per pixel, until the next call; NULL without memory. */
float* view_pixels(view_live* live, int32_t width, int32_t height);
/* Sends an image to all clients, and the method's to tev; one of full size is kept for files. rgb: 3 per pixel. */
void view_show(view_live* live, view_channel channel, const float* rgb, int32_t width, int32_t height, double spp,
               bool final);
/* The same for an image of the method. Returns false without memory. */
bool view_show_image(view_live* live, const ty_image* image, bool final);

/* ---- answers.c: texts for clients ---- */

json_t* view_number(double value); /* null where it is not finite */
json_t* view_presets(void);        /* names of media */

void view_tell_status(view_live* live, bool at_once);
/* Renews document and view, and sends them to all clients; changed: an array of paths, or NULL. */
void view_tell_scene(view_live* live, const json_t* changed);
char* view_welcome(view_live* live); /* under the mutex; freed with free() */
void view_refuse(view_server* server, int32_t client, json_int_t id, const char* text);
void view_answer_document(view_live* live, const view_request* request);
void view_answer_done(view_live* live, const view_request* request, const char* key, const char* value);
/* To a `set` with an id that changed nothing, of which no `scene` tells. */
void view_answer_unchanged(view_live* live, const view_request* request);

/* ---- pictures.c: images for files ---- */

/* Keeps a full image of a channel; rgb: 3 per pixel. */
void view_keep_picture(view_live* live, view_channel channel, const float* rgb, int32_t width, int32_t height,
                       double spp);
/* Shows the picture of a channel again, if it is of the present revision. */
void view_show_picture(view_live* live, view_channel channel);
/* Writes the picture of the method's channel to a file. Returns false after one line in text. */
bool view_write_picture(view_live* live, view_channel channel, const char* path, char* text, size_t size);

#endif
