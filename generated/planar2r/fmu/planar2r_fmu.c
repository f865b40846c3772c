/* planar2r: forward dynamics as a unit of the Functional Mock-up Interface 2.0.
 *
 * Model exchange: states q, qd; inputs tau. Co-simulation: the method of Runge and Kutta of fourth
 * order, torques held over a communication step, which is divided into steps of at most
 * integration_step.
 */
#include "fmi2.h"

#include <math.h>
#include <string.h>

#include "planar2r.h"

enum {
    N = planar2r_JOINTS,
    P = planar2r_PARAMETERS,
    TAU = 0, /* value references: where each array begins */
    Q = N,
    QD = 2 * N,
    DER = 3 * N, /* of q, then of qd */
    X = 5 * N,
    STEP = 5 * N + P,
    VALUES
};

static const char guid[] = "{3b3db9c5cf5edeeaddb16a11ea1fe976}";
static const fmi2Real start[VALUES] = {
    [X] = 0.898583, 0.214296, 0.143341, -0.268162, 0.0001,
};

typedef struct {
    fmi2Real time;
    fmi2Real value[VALUES];
} state;

typedef struct {
    state now;
    fmi2CallbackFunctions use;
    int known; /* nonzero: the derivatives are those of the other values */
    char name[64];
} instance;

static fmi2Status fail(const instance *m, const char *why)
{
    if (m->use.logger != NULL) {
        m->use.logger(m->use.componentEnvironment, m->name, fmi2Error, "logStatusError", why);
    }
    return fmi2Error;
}

/* The accelerations of a state. Returns 0; nonzero: M is not positive definite. */
static int accelerate(const fmi2Real *value, const fmi2Real *q, const fmi2Real *qd, fmi2Real *qdd)
{
    planar2r_real position[N], speed[N], torque[N], parameters[P], out[N];
    fmi2Real tau[N];
    (void)memcpy(tau, value + TAU, sizeof tau);
    for (int j = 0; j < N; ++j) {
        position[j] = (planar2r_real)q[j];
        speed[j] = (planar2r_real)qd[j];
        torque[j] = (planar2r_real)tau[j];
    }
    for (int i = 0; i < P; ++i) {
        parameters[i] = (planar2r_real)value[X + i];
    }
    const int status = planar2r_forward_dynamics(position, speed, torque, parameters, out);
    for (int j = 0; j < N; ++j) {
        qdd[j] = (fmi2Real)out[j];
    }
    return status;
}

/* Bring the derivatives up to date. */
static fmi2Status derive(instance *m)
{
    fmi2Real *value = m->now.value;
    if (m->known == 0) {
        (void)memcpy(value + DER, value + QD, N * sizeof *value);
        if (accelerate(value, value + Q, value + QD, value + DER + N) != 0) {
            return fail(m, "the mass matrix is not positive definite: look at the parameters");
        }
        m->known = 1;
    }
    return fmi2OK;
}

/* One step h of Runge and Kutta's method. Returns 0; nonzero: M is not positive definite. */
static int advance(fmi2Real *value, fmi2Real h)
{
    static const fmi2Real reach[] = { 0.0, 0.5, 0.5, 1.0 };
    static const fmi2Real weight[] = { 1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6 };
    fmi2Real rate[2 * N] = { 0 }, mean[2 * N] = { 0 };
    int failed = 0;
    for (int stage = 0; stage < 4; ++stage) {
        fmi2Real x[2 * N];
        for (int i = 0; i < 2 * N; ++i) {
            x[i] = value[Q + i] + reach[stage] * h * rate[i];
        }
        (void)memcpy(rate, x + N, N * sizeof *x);
        failed |= accelerate(value, x, x + N, rate + N);
        for (int i = 0; i < 2 * N; ++i) {
            mean[i] += weight[stage] * rate[i];
        }
    }
    for (int i = 0; i < 2 * N; ++i) {
        value[Q + i] += h * mean[i];
    }
    return failed;
}

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
fmi2Status FMI2(fmi2EnterInitializationMode)(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

fmi2Status FMI2(fmi2ExitInitializationMode)(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

fmi2Status FMI2(fmi2Terminate)(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

fmi2Status FMI2(fmi2EnterEventMode)(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

fmi2Status FMI2(fmi2EnterContinuousTimeMode)(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

fmi2Status FMI2(fmi2CancelStep)(fmi2Component c)
{
    return c != NULL ? fmi2OK : fmi2Error;
}

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
fmi2Status FMI2(fmi2GetInteger)(fmi2Component c, fmi2References vr, size_t n, fmi2Integer value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

fmi2Status FMI2(fmi2SetInteger)(
    fmi2Component c, fmi2References vr, size_t n, const fmi2Integer value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

fmi2Status FMI2(fmi2GetBoolean)(fmi2Component c, fmi2References vr, size_t n, fmi2Boolean value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

fmi2Status FMI2(fmi2SetBoolean)(
    fmi2Component c, fmi2References vr, size_t n, const fmi2Boolean value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

fmi2Status FMI2(fmi2GetString)(fmi2Component c, fmi2References vr, size_t n, fmi2String value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

fmi2Status FMI2(fmi2SetString)(
    fmi2Component c, fmi2References vr, size_t n, const fmi2String value[])
{
    (void)vr, (void)value;
    return n == 0 ? fmi2OK : fail(c, "there are real variables only");
}

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

fmi2Status FMI2(fmi2GetStatus)(
    fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* every step is done when it returns */
}

fmi2Status FMI2(fmi2GetRealStatus)(
    fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* every step is done when it returns */
}

fmi2Status FMI2(fmi2GetIntegerStatus)(
    fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* every step is done when it returns */
}

fmi2Status FMI2(fmi2GetBooleanStatus)(
    fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* every step is done when it returns */
}

fmi2Status FMI2(fmi2GetStringStatus)(
    fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard; /* every step is done when it returns */
}

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
