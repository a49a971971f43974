/* errors.json of `tyndall compare`. */
#include "cli/compare/files.h"
#include "cli/images/difference.h"

static void slots_json(json_writer* json, const char* name, const double values[4]) {
    json_open_object(json, name);
    for (int i = 0; i < 4; ++i) json_number(json, cli_difference_names[i], values[i]);
    json_close_object(json);
}

static void image_json(json_writer* json, const cli_compared* image) {
    json_text(json, "name", image->name);
    json_text(json, "source", image->source);
    if (image->seconds >= 0) json_number(json, "seconds", image->seconds);
    if (image->own_seconds >= 0) json_number(json, "own_seconds", image->own_seconds);
    if (image->spp >= 0) json_number(json, "spp", image->spp);
    if (image->command != NULL) json_text(json, "command", image->command);
    if (image->stage_count == 0) return;
    json_open_array(json, "stages");
    for (int i = 0; i < image->stage_count; ++i) {
        json_open_object(json, NULL);
        json_text(json, "name", image->stages[i].name);
        json_number(json, "seconds", image->stages[i].seconds);
        json_close_object(json);
    }
    json_close_array(json);
}

static void reference_json(json_writer* json, const cli_comparison* comparison) {
    const cli_compared* reference = &comparison->reference;
    json_open_object(json, "reference");
    image_json(json, reference);
    if (comparison->hash[0] != '\0') json_bool(json, "stored", comparison->reference_stored);
    if (reference->noise.known) {
        char sentence[256];
        cli_noise_sentence(comparison, sentence, sizeof sentence);
        slots_json(json, "noise", reference->noise.rmse);
        slots_json(json, "relative_noise", reference->noise.relative);
        json_text(json, "noise_is", sentence);
        const cli_compared* nearest = cli_nearest_entry(comparison);
        if (nearest != NULL && nearest->difference.rmse[3] > 0) {
            json_text(json, "nearest", nearest->name);
            json_number(json, "noise_share", reference->noise.rmse[3] / nearest->difference.rmse[3]);
        }
        if (comparison->hash[0] != '\0') json_number(json, "noise_share_wanted", comparison->wanted);
    }
    json_close_object(json);
}

/* Errors after subtraction of the reference's noise. */
static void without_noise_json(json_writer* json, const cli_compared* entry) {
    double rmse[4], relative[4];
    for (int i = 0; i < 4; ++i) {
        rmse[i] = cli_without_noise(entry->difference.rmse[i], entry->noise.rmse[i]);
        relative[i] = cli_without_noise(entry->difference.relative_rmse[i], entry->noise.relative[i]);
    }
    slots_json(json, "rmse_without_noise", rmse);
    slots_json(json, "relative_rmse_without_noise", relative);
}

static void time_json(json_writer* json, double spp, double seconds, const ty_difference* difference) {
    json_open_object(json, NULL);
    if (spp >= 0) json_number(json, "spp", spp);
    json_number(json, "seconds", seconds);
    json_number(json, "rmse", difference->rmse[3]);
    json_number(json, "relative_rmse", difference->relative_rmse[3]);
    json_close_object(json);
}

static void error_against_time_json(json_writer* json, const cli_compared* entry) {
    if (entry->seconds < 0) return;
    json_open_array(json, "error_against_time");
    for (int i = 0; i < entry->earlier_count; ++i)
        time_json(json, entry->earlier[i].spp, entry->earlier[i].seconds, &entry->earlier[i].difference);
    time_json(json, entry->spp, entry->seconds, &entry->difference);
    json_close_array(json);
}

void cli_comparison_json(json_writer* json, const void* user) {
    const cli_comparison* comparison = user;
    if (comparison->subject != NULL) json_text(json, "scene", comparison->subject);
    if (comparison->hash[0] != '\0') json_text(json, "scene_hash", comparison->hash);
    json_number(json, "exposure", comparison->exposure);
    reference_json(json, comparison);
    json_open_array(json, "images");
    for (int i = 0; i < comparison->count; ++i) {
        const cli_compared* entry = &comparison->entries[i];
        json_open_object(json, NULL);
        image_json(json, entry);
        cli_difference_json(json, &entry->difference);
        if (entry->noise.known) without_noise_json(json, entry);
        error_against_time_json(json, entry);
        json_close_object(json);
    }
    json_close_array(json);
    json_open_array(json, "skipped");
    for (int i = 0; i < comparison->skipped_count; ++i) {
        json_open_object(json, NULL);
        json_text(json, "name", comparison->skipped[i].name);
        json_text(json, "reason", comparison->skipped[i].reason);
        json_close_object(json);
    }
    json_close_array(json);
}

void cli_comparison_scene_json(json_writer* json, const cli_comparison* comparison) {
    if (comparison->overrides != NULL && comparison->overrides->count > 0) {
        json_open_array(json, "defines");
        for (int i = 0; i < comparison->overrides->count; ++i) json_text(json, NULL, comparison->overrides->items[i]);
        json_close_array(json);
    }
    if (comparison->scene_text != NULL) json_text(json, "scene_text", comparison->scene_text);
}
