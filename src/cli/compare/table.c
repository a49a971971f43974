/* table.md of `tyndall compare`. */
#include "cli/compare/files.h"
#include "cli/images/difference.h"

static void print_amount(FILE* file, double amount) {
    if (amount >= 0)
        fprintf(file, " %.4g |", amount);
    else
        fputs(" |", file);
}

static void print_head(FILE* file, const cli_comparison* comparison) {
    const cli_compared* reference = &comparison->reference;
    char sentence[256];
    cli_noise_sentence(comparison, sentence, sizeof sentence);
    if (comparison->subject != NULL) fprintf(file, "Scene: %s\n\n", comparison->subject);
    fprintf(file, "Reference: %s (%s)", reference->name, reference->source);
    if (reference->spp >= 0) fprintf(file, ", %.6g spp", reference->spp);
    if (reference->seconds >= 0) fprintf(file, ", %.4g s", reference->seconds);
    fprintf(file, "%s%s\n\n", sentence[0] != '\0' ? ". " : "", sentence);
}

static void print_rows(FILE* file, const cli_compared* entry) {
    const ty_difference* d = &entry->difference;
    for (int channel = 0; channel < 4; ++channel) {
        char without[24];
        cli_without_noise_text(entry, channel, without);
        fprintf(file, "| %s | %s | %.6g | %.6g | %.6g | %s |", entry->name, cli_difference_names[channel],
                d->mean_ratio[channel], d->rmse[channel], d->relative_rmse[channel], without);
        fprintf(file, " %.6g |", d->rel_mse[channel]);
        print_amount(file, entry->spp);
        print_amount(file, entry->seconds);
        fputc('\n', file);
    }
}

ty_result cli_print_comparison_table(ty_context* context, FILE* file, const void* user) {
    (void)context;
    const cli_comparison* comparison = user;
    print_head(file, comparison);
    fputs("| image | channel | mean ratio | RMSE | relative RMSE | without noise | relMSE | spp | seconds |\n"
          "|---|---|---|---|---|---|---|---|---|\n",
          file);
    for (int i = 0; i < comparison->count; ++i) print_rows(file, &comparison->entries[i]);
    if (comparison->skipped_count > 0) fputs("\nLeft out, since they are not made for the scene:\n\n", file);
    for (int i = 0; i < comparison->skipped_count; ++i)
        fprintf(file, "- %s: %s\n", comparison->skipped[i].name, comparison->skipped[i].reason);
    fprintf(file,
            "\nMean ratio: mean / mean of the reference. Relative RMSE: RMSE / mean of the reference; without noise: "
            "the reference's noise taken out of it, sqrt(error^2 - noise^2), where that is more than a third of it. "
            "relMSE: mean of error^2 / (reference^2 + "
            "0.01 mean^2).\n\nHeat maps: red where the image is brighter than the reference, blue where it is darker; "
            "full colour at 100 percent of the reference, or of a tenth of its mean where that is more. Green: not "
            "finite.\n");
    return TY_OK;
}
