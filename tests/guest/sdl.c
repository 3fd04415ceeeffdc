/* Says what SDL2 sees of the first game controller: its name, then a line each time a button or an axis changes, then
 * `gone`. Declares what it uses, so that no header need be installed: this part of SDL2's interface is frozen. */
#include <stdint.h>
#include <stdio.h>

typedef struct SDL_GameController SDL_GameController;
enum { INIT_GAMECONTROLLER = 0x2000, BUTTONS = 15, AXES = 6, WAIT_MS = 1, PATIENCE = 10000 };

int SDL_Init(uint32_t flags);
int SDL_NumJoysticks(void);
int SDL_IsGameController(int index);
SDL_GameController *SDL_GameControllerOpen(int index);
const char *SDL_GameControllerName(SDL_GameController *controller);
int SDL_GameControllerGetAttached(SDL_GameController *controller);
uint8_t SDL_GameControllerGetButton(SDL_GameController *controller, int button);
int16_t SDL_GameControllerGetAxis(SDL_GameController *controller, int axis);
const char *SDL_GameControllerGetStringForButton(int button);
const char *SDL_GameControllerGetStringForAxis(int axis);
void SDL_GameControllerUpdate(void);
void SDL_Delay(uint32_t ms);
const char *SDL_GetError(void);

int main(void) {
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (SDL_Init(INIT_GAMECONTROLLER) != 0) {
        fprintf(stderr, "SDL2: %s\n", SDL_GetError());
        return 1;
    }
    SDL_GameController *controller = NULL;
    for (int waited = 0; controller == NULL && waited < PATIENCE; waited++) {
        SDL_GameControllerUpdate();
        for (int index = 0; controller == NULL && index < SDL_NumJoysticks(); index++)
            if (SDL_IsGameController(index)) controller = SDL_GameControllerOpen(index);
        SDL_Delay(WAIT_MS);
    }
    if (controller == NULL) {
        fprintf(stderr, "SDL2 finds no game controller among %d joysticks\n", SDL_NumJoysticks());
        return 1;
    }
    printf("%s\n", SDL_GameControllerName(controller));

    int buttons[BUTTONS] = {0}, axes[AXES] = {0};
    while (SDL_GameControllerGetAttached(controller)) {
        SDL_GameControllerUpdate();
        for (int button = 0; button < BUTTONS; button++) {
            int now = SDL_GameControllerGetButton(controller, button);
            if (now != buttons[button]) printf("%s %d\n", SDL_GameControllerGetStringForButton(button), now);
            buttons[button] = now;
        }
        for (int axis = 0; axis < AXES; axis++) {
            int now = SDL_GameControllerGetAxis(controller, axis);
            if (now != axes[axis]) printf("%s %d\n", SDL_GameControllerGetStringForAxis(axis), now);
            axes[axis] = now;
        }
        SDL_Delay(WAIT_MS);
    }
    printf("gone\n");
    return 0;
}
