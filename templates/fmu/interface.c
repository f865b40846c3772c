/* What the standard asks for. */

const char *FMI2(fmi2GetTypesPlatform)(void)
{
    return fmi2TypesPlatform;
}

const char *FMI2(fmi2GetVersion)(void)
{
    return fmi2Version;
}

fmi2Status FMI2(fmi2SetDebugLogging)(
    fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)c, (void)on, (void)n, (void)categories; /* errors are always logged, nothing else is */
    return fmi2OK;
}

fmi2Status FMI2(fmi2Reset)(fmi2Component c)
{
    instance *m = c;
    m->now.time = 0.0;
    (void)memcpy(m->now.value, start, sizeof start);
    m->known = 0;
    return fmi2OK;
}

fmi2Component FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String key,
    fmi2String resources, const fmi2CallbackFunctions *functions, fmi2Boolean visible,
    fmi2Boolean logging)
{
    (void)type, (void)resources, (void)visible, (void)logging;
    if (functions == NULL || functions->allocateMemory == NULL || functions->freeMemory == NULL) {
        return NULL;
    }
    if (key == NULL || strcmp(key, guid) != 0) {
        if (functions->logger != NULL) {
            functions->logger(functions->componentEnvironment, name, fmi2Error, "logStatusError",
                "the guid is that of another model");
        }
        return NULL;
    }
    instance *m = functions->allocateMemory(1, sizeof *m);
    if (m != NULL) {
        m->use = *functions;
        m->name[0] = '\0';
        if (name != NULL) {
            (void)strncat(m->name, name, sizeof m->name - 1);
        }
        (void)FMI2(fmi2Reset)(m);
    }
    return m;
}

void FMI2(fmi2FreeInstance)(fmi2Component c)
{
    if (c != NULL) {
        ((instance *)c)->use.freeMemory(c);
    }
}

fmi2Status FMI2(fmi2SetTime)(fmi2Component c, fmi2Real time)
{
    ((instance *)c)->now.time = time;
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean given, fmi2Real tolerance,
    fmi2Real begin, fmi2Boolean ends, fmi2Real stop)
{
    (void)given, (void)tolerance, (void)ends, (void)stop;
    return FMI2(fmi2SetTime)(c, begin);
}

/* Nothing happens where modes change: there are no events. */
{% for mode in ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "EnterEventMode", "EnterContinuousTimeMode", "CancelStep") %}
fmi2Status FMI2(fmi2{{ mode }})(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

{% endfor %}
fmi2Status FMI2(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info)
{
    (void)c;
    (void)memset(info, 0, sizeof *info);
    return fmi2OK;
}

fmi2Status FMI2(fmi2CompletedIntegratorStep)(
    fmi2Component c, fmi2Boolean never_back, fmi2Boolean *event, fmi2Boolean *terminate)
{
    (void)c, (void)never_back;
    *event = fmi2False;
    *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetReal)(fmi2Component c, fmi2References vr, size_t n, fmi2Real value[])
{
    instance *m = c;
    for (size_t i = 0; i < n; ++i) {
        if (vr[i] >= VALUES) {
            return fail(m, "there is no variable with this value reference");
        }
        if (vr[i] >= DER && vr[i] < X && derive(m) != fmi2OK) {
            return fmi2Error;
        }
        value[i] = m->now.value[vr[i]];
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetReal)(fmi2Component c, fmi2References vr, size_t n, const fmi2Real value[])
{
    instance *m = c;
    for (size_t i = 0; i < n; ++i) {
        if (vr[i] >= VALUES || (vr[i] >= DER && vr[i] < X)) {
            return fail(m, "no variable that may be set has this value reference");
        }
        if (vr[i] >= STEP && !(value[i] > 0.0)) {
            return fail(m, "integration_step and coulomb_width are above 0");
        }
        m->now.value[vr[i]] = value[i];
        m->known = 0;
    }
    return fmi2OK;
}

/* There are no variables of other types. */
{% for type in ("Integer", "Boolean", "String") %}
fmi2Status FMI2(fmi2Get{{ type }})(fmi2Component c, fmi2References vr, size_t n, fmi2{{ type }} value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

fmi2Status FMI2(fmi2Set{{ type }})(
    fmi2Component c, fmi2References vr, size_t n, const fmi2{{ type }} value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

{% endfor %}
fmi2Status FMI2(fmi2SetContinuousStates)(fmi2Component c, const fmi2Real x[], size_t n)
{
    instance *m = c;
    if (n != 2 * N) {
        return fail(m, "states are q, then qd");
    }
    (void)memcpy(m->now.value + Q, x, n * sizeof *x);
    m->known = 0;
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetContinuousStates)(fmi2Component c, fmi2Real x[], size_t n)
{
    instance *m = c;
    if (n != 2 * N) {
        return fail(m, "states are q, then qd");
    }
    (void)memcpy(x, m->now.value + Q, n * sizeof *x);
    return fmi2OK;
}

fmi2Status FMI2(fmi2GetDerivatives)(fmi2Component c, fmi2Real derivatives[], size_t n)
{
    instance *m = c;
    if (n != 2 * N) {
        return fail(m, "states are q, then qd");
    }
    const fmi2Status status = derive(m);
    (void)memcpy(derivatives, m->now.value + DER, n * sizeof *derivatives);
    return status;
}

fmi2Status FMI2(fmi2GetEventIndicators)(fmi2Component c, fmi2Real indicators[], size_t n)
{
    (void)indicators;
    return n == 0 ? fmi2OK : fail(c, "there are no event indicators");
}

fmi2Status FMI2(fmi2GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real nominal[], size_t n)
{
    (void)c;
    for (size_t i = 0; i < n; ++i) {
        nominal[i] = 1.0;
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean never_back)
{
    instance *m = c;
    (void)never_back;
    const fmi2Real parts = ceil(step / m->now.value[STEP] * (1.0 - 1e-12));
    if (!(step >= 0.0 && parts < 1e9)) {
        return fail(m, "the communication step is negative or too many integration steps long");
    }
    for (fmi2Real i = 0.0; i < parts; i += 1.0) {
        if (advance(m->now.value, step / parts) != 0) {
            return fail(m, "the mass matrix is not positive definite: look at the parameters");
        }
    }
    m->now.time = time + step;
    m->known = 0;
    for (int i = Q; i < DER; ++i) {
        if (!(fabs(m->now.value[i]) < HUGE_VAL)) {
            return fail(m, "the motion is not finite: integration_step may be too long");
        }
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetRealInputDerivatives)(fmi2Component c, fmi2References vr, size_t n,
    const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    return n == 0 ? fmi2OK : fail(c, "inputs are held over a step");
}

fmi2Status FMI2(fmi2GetRealOutputDerivatives)(
    fmi2Component c, fmi2References vr, size_t n, const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    return n == 0 ? fmi2OK : fail(c, "derivatives are outputs of their own");
}

{% for type in ("Status", "RealStatus", "IntegerStatus", "BooleanStatus", "StringStatus") %}
fmi2Status FMI2(fmi2Get{{ type }})(
    fmi2Component c, const fmi2StatusKind kind, fmi2{{ type|replace("Status", "") or "Status" }} *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* every step is done when it returns */
}

{% endfor %}
fmi2Status FMI2(fmi2GetDirectionalDerivative)(fmi2Component c, fmi2References of, size_t rows,
    fmi2References by, size_t columns, const fmi2Real along[], fmi2Real value[])
{
    (void)of, (void)rows, (void)by, (void)columns, (void)along, (void)value;
    return fail(c, "there are no directional derivatives");
}

fmi2Status FMI2(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *kept)
{
    instance *m = c;
    if (*kept == NULL) {
        *kept = m->use.allocateMemory(1, sizeof(state));
    }
    if (*kept == NULL) {
        return fail(m, "out of memory");
    }
    (void)memcpy(*kept, &m->now, sizeof(state));
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate kept)
{
    instance *m = c;
    (void)memcpy(&m->now, kept, sizeof(state));
    m->known = 0;
    return fmi2OK;
}

fmi2Status FMI2(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *kept)
{
    if (*kept != NULL) {
        ((instance *)c)->use.freeMemory(*kept);
        *kept = NULL;
    }
    return fmi2OK;
}

fmi2Status FMI2(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate kept, size_t *size)
{
    (void)c, (void)kept;
    *size = sizeof(state);
    return fmi2OK;
}

fmi2Status FMI2(fmi2SerializeFMUstate)(
    fmi2Component c, fmi2FMUstate kept, fmi2Byte bytes[], size_t size)
{
    if (size != sizeof(state)) {
        return fail(c, "a state has another size");
    }
    (void)memcpy(bytes, kept, size);
    return fmi2OK;
}

fmi2Status FMI2(fmi2DeSerializeFMUstate)(
    fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *kept)
{
    if (size != sizeof(state)) {
        return fail(c, "a state has another size");
    }
    const fmi2Status status = FMI2(fmi2GetFMUstate)(c, kept); /* for its memory */
    if (status == fmi2OK) {
        (void)memcpy(*kept, bytes, size);
    }
    return status;
}
