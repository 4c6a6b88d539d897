/* The narrow waist between the generated model and the runtime.
 *
 * A generated file defines, before it includes this one, the sizes
 *   N_STATES N_INPUTS N_GIVEN N_PARAMETERS N_PREPARED N_MODES N_INDICATORS N_OUTPUTS, N_..._JACOBIAN
 * and after it the tables state_nominal, mode_start, output_at_motor, rate_of (the index of the
 * input whose rate an input is, else -1; N_GIVEN are none) and the functions
 *   model_rates, model_outputs, model_indicators, model_next_modes,
 *   model_starts, model_delay                                        (x, u, p, r, result)
 *   model_reset                                                      (x, u, p, r, r_next, result)
 *   model_starts     the start of each calculated state, the other states themselves
 *   model_delay      of the signals measured at the joint, s
 *   model_rates_by_state      dense N_STATES x N_STATES, column by column
 *   model_..._jacobian        nonzeros of the derivative by v = [x; u; p], with its ..._pattern
 *   model_prepare    (p, result) what follows from parameters alone. Every other function takes
 *                    N_PREPARED numbers as p: the parameters and, behind them, these
 * All are pure: caller's memory, no state, libm only. Modes r are constants between events.
 */
#ifndef MODEL_H
#define MODEL_H

/* Compressed columns: nonzeros of column j are columns[j] .. columns[j + 1] - 1. */
typedef struct {
  const int *columns;
  const int *rows;
} Pattern;

/* Offsets of states, inputs and parameters in v. */
#define V_STATES 0
#define V_INPUTS N_STATES
#define V_PARAMETERS (N_STATES + N_INPUTS)

#endif
