#include "choose/predict.h"
static const ty_method_model methods[] = {{"path", {{0}}},{"dom", {{0}}},{"fld", {{0}}},{"cda", {{0}}},{"pop", {{0}}},{"lpv", {{0}}}};
const ty_choice_model ty_fitted_model = {sizeof methods / sizeof methods[0], methods};
