/* The reference of the viewer: independent images by path, summed in two halves, of which the difference tells the
 * noise. */
#ifndef TY_CLI_VIEW_ACCUMULATE_H
#define TY_CLI_VIEW_ACCUMULATE_H

#include <tyndall/tyndall.h>

/* All zero at first. */
typedef struct view_accumulation {
    int32_t width, height;
    float* half[2];  /* sums of radiance times samples, 3 per pixel */
    double spp[2];   /* samples per pixel */
    double seconds;  /* of rendering */
    int32_t batch;   /* samples per pixel of the next image of each half */
    uint64_t images; /* added so far: part of the seed */
    bool unscattered;
    const struct ty_enclosed_field* enclosed; /* light in media inside dielectrics; NULL: none */
} view_accumulation;

/* Empties it for images of this size; unscattered, and `enclosed` at first: as in ty_path_def. Returns false without
 * memory. */
bool view_accumulation_reset(view_accumulation* sum, int32_t width, int32_t height, bool unscattered);
void view_accumulation_free(view_accumulation* sum);
/* Adds one image to each half; batches grow until they take about a third of a second. With a progress that cancels,
 * TY_CANCELLED leaves the sums as they were. Errors: those of ty_path_render. */
ty_result view_accumulation_add(view_accumulation* sum, const ty_scene* scene, int32_t spp_max, ty_progress_fn progress,
                                void* user);
/* Samples per pixel of both halves. */
double view_accumulation_spp(const view_accumulation* sum);
/* Stores the mean, 3 per pixel; 0 before the first image. */
void view_accumulation_mean(const view_accumulation* sum, float* rgb);

/* The difference of an image from the mean, by luminance. */
typedef struct view_difference {
    double mean_ratio; /* mean(image) / mean(path) */
    double rmse;       /* root mean square over blocks of 8 x 8 pixels, relative to the mean of path */
    double noise;      /* the same of half the difference of the two halves: the part that is path's noise */
} view_difference;

/* rgb: 3 per pixel, of the same size. False without samples in both halves, or where path's mean is 0. */
bool view_accumulation_compare(const view_accumulation* sum, const float* rgb, view_difference* out);

#endif
