/* The baker's kernel; built once per instruction set, with TY_ISA naming it. */
#include "bake/cached.k.h"

#include "base/float_mode.h"

#define TY_JOIN_(a, b) a##b
#define TY_JOIN(a, b) TY_JOIN_(a, b)

/* How far off the surface rays start that look behind it: as far as light goes before it scatters, but not to the next
 * surface. */
static float step_off(const ty_gather* g) {
    const ty_scene_view* scene = g->request->path.scene;
    const bool probe = g->request->terms == TY_BAKE_SH_TERMS;
    const ty_vec from = ty_mad(g->position, g->face, g->receiver->margin);
    const ty_vec away = probe ? ty_vec_make(0.0f, 0.0f, 1.0f) : g->face;
    ty_segment segment;
    ty_hit hit;
    const bool met = scene->mesh != NULL && ty_mesh_intersect(scene->mesh, from, away, TY_FLOAT_MAX, &hit);
    ty_gather_segment(g, from, away, met ? hit.distance : TY_FLOAT_MAX, &segment);
    const float room = met ? hit.distance : segment.leave;
    const float free = segment.leave / ty_maxf(ty_max3(segment.depth), 1e-6f);
    return ty_maxf(g->receiver->margin, 0.5f * ty_minf(room, free));
}

TY_BAKE_KERNEL(TY_JOIN(ty_bake_kernel_, TY_ISA)) {
    const unsigned thread_state = ty_flush_denormals();
    ty_gather g = {.request = request};
    const bool scatters = ty_gather_scatters(&g), behind = scatters && request->terms == TY_BAKE_SURFACE_TERMS;
    const bool cached = request->method == TY_BAKE_CACHE && request->path.scene->medium_count > 0;
    for (int64_t item = begin; item < end; ++item) {
        ty_bake_sums* sum = &sums[item];
        if (sum->done != 0) continue;
        g.receiver = &request->receivers[item];
        g.position = ty_vec_load(g.receiver->position);
        g.normal = ty_vec_load(g.receiver->normal);
        g.face = ty_vec_load(g.receiver->face);
        g.light = light + item * (TY_BAKE_LAYERS * 3) * request->terms;
        g.rays = 0;
        g.sums = sum;
        g.once = 1.0f;
        for (int c = 0; c < 3; ++c) g.most[c] = ty_response_most(sum->depth[c], sum->stopped[c]);
        if (scatters) g.step = step_off(&g);
        for (uint32_t i = first; i < first + count; ++i) {
            for (int c = 0; c < 3; ++c) g.sample[c] = 0.0f;
            if (cached ? ty_cached_sample(&g, (uint64_t)item, i) : ty_gather_sample(&g, (uint64_t)item, i))
                sum->blocked += 1;
            if (behind && i % TY_BACK_EVERY == 0) {
                ty_path_begin(&g.path, &g.request->path, ~(uint64_t)item, i / TY_BACK_EVERY);
                ty_gather_behind(&g);
            }
            for (int c = 0; c < 3; ++c) {
                sum->mean[c] += (double)g.sample[c];
                sum->square[c] += (double)g.sample[c] * (double)g.sample[c];
            }
        }
        sum->paths += count;
        sum->rays += g.rays;
        sum->count += (int32_t)count;
    }
    ty_restore_denormals(thread_state);
}
