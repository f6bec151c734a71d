/* Hierarq for C and C++: compiled programs stepped in a loop of the host.

   Numbers are in SI units. Functions accept null pointers: they answer with a failure, 0, NaN or null. Other pointers must be those of this
   library, not freed yet, or arrays and buffers of the length that is passed beside them; texts end with a zero. A program may be used by
   several threads at once; a controller by one thread at a time. Made by cbindgen; the text is that of c/src. */

#ifndef HIERARQ_H
#define HIERARQ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 Outcome of a tick: `HIERARQ_RESULT_OK`, the kind of a fault (above 0), or a mistake of the host (below 0). With all but the first the
 velocity is zero, unless a transition of the machine answers the fault.
 */
enum hierarq_result
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  /*
   A pointer is null.
   */
  HIERARQ_RESULT_NULL_POINTER = -1,
  /*
   An array has another length than the robot has numbers.
   */
  HIERARQ_RESULT_WRONG_LENGTH = -2,
  /*
   The library has failed. The controller stands still until it is restarted.
   */
  HIERARQ_RESULT_INTERNAL = -3,
  /*
   The velocity is that of the hierarchy.
   */
  HIERARQ_RESULT_OK = 0,
  /*
   A number of the configuration, or of a solution, is not finite.
   */
  HIERARQ_RESULT_NOT_FINITE = 1,
  /*
   The tick came too late, or its time goes back.
   */
  HIERARQ_RESULT_DEADLINE = 2,
  /*
   A signal is too old, or was never sent.
   */
  HIERARQ_RESULT_STALE = 3,
  /*
   The value of an expression is out of its range.
   */
  HIERARQ_RESULT_VALUE = 4,
  /*
   The bounds of a row cross.
   */
  HIERARQ_RESULT_CROSSED = 5,
  /*
   Shapes overlap, so that no direction leads apart.
   */
  HIERARQ_RESULT_OVERLAP = 6,
  /*
   A hard level cannot be met.
   */
  HIERARQ_RESULT_INFEASIBLE = 7,
  /*
   A hard limit is passed.
   */
  HIERARQ_RESULT_LIMIT = 8,
  /*
   The solver has not found the solution.
   */
  HIERARQ_RESULT_SOLVER = 9,
  /*
   A joint does not follow what it is told.
   */
  HIERARQ_RESULT_TRACKING = 10,
  /*
   A joint cannot have reached its reading since the last one.
   */
  HIERARQ_RESULT_JUMP = 11,
  /*
   The measured robot has passed a hard limit.
   */
  HIERARQ_RESULT_BEYOND = 12,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum hierarq_result hierarq_result;
#else
typedef int32_t hierarq_result;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/*
 A program made ready, with its state between ticks.
 */
typedef struct hierarq_controller hierarq_controller;

/*
 A compiled program with the robot that it is for. Nothing changes it.
 */
typedef struct hierarq_program hierarq_program;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Makes a controller of a program: of its run, or of the stack with this name if it is not null. Returns null if there is none, with the reason in
 `message`, a buffer of `capacity` bytes that may be null.
 */
hierarq_controller *hierarq_controller_new(const hierarq_program *program,
                                           const char *stack,
                                           char *message,
                                           size_t capacity);

/*
 Frees a controller.
 */
void hierarq_controller_free(hierarq_controller *controller);

/*
 Begins anew: the next tick is the first one.
 */
void hierarq_restart(hierarq_controller *controller);

/*
 Tells the time between two calls of `hierarq_step`, in s. Calls may come at any rate: the motion is the same. Without this, or with a number that is
 not positive, it is found from the calls, and the robot stands still until the second one.
 */
void hierarq_called_every(hierarq_controller *controller,
                          double interval);

/*
 Mean rate of the calls of `hierarq_step` (Hz), faults of time left out; 0 before the second one. The spec's rate is one divided by
 `hierarq_period`: a mean that differs by more than 5 % where one call a period is meant says that the host's loop has another rate.
 */
double hierarq_measured_rate(const hierarq_controller *controller);

/*
 Tells whether the robot takes commands: its program runs, its brakes are open. While it does not, the reference stays with the robot; afterwards
 the robot stands until `hierarq_resume`. A controller begins with a robot that does.
 */
void hierarq_enabled(hierarq_controller *controller,
                     bool enabled);

/*
 Brings the robot to rest within its limits, where it stands until `hierarq_resume`. Call `hierarq_step` until `hierarq_at_rest`.
 */
void hierarq_stop(hierarq_controller *controller);

/*
 Lets a robot go on that was stopped, or that takes commands again: from where it is, from rest.
 */
void hierarq_resume(hierarq_controller *controller);

/*
 Tells that the bases are elsewhere at the next call, because they were localised anew: the reference moves with them. Without this, a reading that
 no base can have reached is the fault `HIERARQ_RESULT_JUMP`.
 */
void hierarq_relocated(hierarq_controller *controller);

/*
 True if the robot is told to stand: a host that ends may stop calling.
 */
bool hierarq_at_rest(const hierarq_controller *controller);

/*
 Sends the value of a signal, received at `time` (s): `width` numbers in SI units, a flag above 0 for true. Returns false for null pointers, another
 width, or a signal that the host cannot set.
 */
bool hierarq_signal_set(hierarq_controller *controller,
                        int32_t signal,
                        const double *value,
                        size_t width,
                        double time);

/*
 Says that a signal has become absent. Returns false for a null pointer and a signal that the host cannot set.
 */
bool hierarq_signal_clear(hierarq_controller *controller, int32_t signal);

/*
 Says that an event has occurred. Returns false for a null pointer and an event that does not exist.
 */
bool hierarq_event_raise(hierarq_controller *controller, int32_t event);

/*
 Executes one tick: takes the measured configuration `q` (`nq` numbers, rad or m) at `time` (s) since the start, and writes the velocity until
 the next tick (`nv` numbers, rad/s or m/s), which is finite in any case. It neither allocates nor blocks.
 */
hierarq_result hierarq_step(hierarq_controller *controller,
                            double time,
                            const double *q,
                            size_t nq,
                            double *velocity,
                            size_t nv);

/*
 Writes the fault of the last tick in words into `message`, a buffer of `capacity` bytes; an empty text without a fault.
 */
void hierarq_fault_text(const hierarq_controller *controller, char *message, size_t capacity);

/*
 Path of the active state; an empty text without a machine. The states of regions are joined, `work.left.reach | work.right.wait`; this text changes with
 the next tick. The text is freed with the controller.
 */
const char *hierarq_state(const hierarq_controller *controller);

/*
 True if the machine has ended.
 */
bool hierarq_is_final(const hierarq_controller *controller);

/*
 True if a fault keeps the robot still until `hierarq_restart`.
 */
bool hierarq_is_halted(const hierarq_controller *controller);

/*
 Copies the configuration to be reached at the next call, which a position servo is sent, into an array of `nq` numbers, which are finite in any
 case. Returns false for null pointers and another length.
 */
bool hierarq_position(const hierarq_controller *controller,
                      double *q,
                      size_t nq);

/*
 Copies the reference of the hierarchy after the last decision, into an array of `nq` numbers. Returns false for null pointers and another
 length.
 */
bool hierarq_reference(const hierarq_controller *controller,
                       double *q,
                       size_t nq);

/*
 Number of the tasks of all stacks that may run.
 */
size_t hierarq_task_count(const hierarq_controller *controller);

/*
 Name of a task; null beyond the end. The text is freed with the controller.
 */
const char *hierarq_task_name(const hierarq_controller *controller, size_t task);

/*
 True for a limit, false for a target.
 */
bool hierarq_task_is_limit(const hierarq_controller *controller, size_t task);

/*
 The smallest margin of a limit, negative if it is passed, or the norm of a target's error, in the unit of its rows, at the last tick. NaN if the task
 did not run.
 */
double hierarq_task_value(const hierarq_controller *controller,
                          size_t task);

/*
 Loads a compiled program, the text that `hierarq compile --format json` writes, of `length` bytes. Returns null if it cannot be run, with the
 reason in `message`, a buffer of `capacity` bytes that may be null.
 */
hierarq_program *hierarq_program_load(const char *json,
                                      size_t length,
                                      char *message,
                                      size_t capacity);

/*
 Frees a program. Controllers that were made of it go on.
 */
void hierarq_program_free(hierarq_program *program);

/*
 Name of the spec. The text is freed with the program.
 */
const char *hierarq_program_name(const hierarq_program *program);

/*
 Length of a configuration.
 */
size_t hierarq_nq(const hierarq_program *program);

/*
 Length of a velocity: the number of degrees of freedom.
 */
size_t hierarq_nv(const hierarq_program *program);

/*
 Time between two ticks (s).
 */
double hierarq_period(const hierarq_program *program);

/*
 Name of a number of a configuration: of a joint, or `base_x`, .. Null beyond the end.
 */
const char *hierarq_q_name(const hierarq_program *program, size_t index);

/*
 Name of a degree of freedom. Null beyond the end.
 */
const char *hierarq_v_name(const hierarq_program *program, size_t index);

/*
 Copies the home configuration, rad or m, into an array of `hierarq_nq` numbers. Returns false for null pointers and another length.
 */
bool hierarq_home(const hierarq_program *program,
                  double *q,
                  size_t nq);

/*
 Number of signals, variables of the machine among them.
 */
size_t hierarq_signal_count(const hierarq_program *program);

/*
 Name of a signal. Null beyond the end.
 */
const char *hierarq_signal_name(const hierarq_program *program, size_t index);

/*
 Number of numbers of a signal's value: 1 for a number or a flag, 3 for a point, 7 for a pose (x, y, z, then a quaternion w, x, y, z), 6 for a wrench;
 with a measured velocity, that follows. 0 for a variable of the machine, which the host cannot set, and beyond the end.
 */
size_t hierarq_signal_width(const hierarq_program *program,
                            size_t index);

/*
 Index of the signal with this name, or -1.
 */
int32_t hierarq_signal_index(const hierarq_program *program, const char *name);

/*
 Index of the event with this name, or -1.
 */
int32_t hierarq_event_index(const hierarq_program *program, const char *name);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HIERARQ_H */
