// The part of TivaWare's driver library that the library uses. The headers beside this one include it.
#ifndef STUB_DRIVERLIB_H_
#define STUB_DRIVERLIB_H_

#include <stdbool.h>
#include <stdint.h>

#define GPIO_PIN_0 0x01
#define GPIO_PIN_1 0x02
#define GPIO_PA0_U0RX 0x00000001
#define GPIO_PA1_U0TX 0x00000401
#define GPIO_PORTA_BASE 0x40004000
#define UART0_BASE 0x4000C000
#define INT_UART0 21
#define SYSCTL_PERIPH_GPIOA 0xf0000800
#define SYSCTL_PERIPH_UART0 0xf0001800
#define UART_CONFIG_WLEN_8 0x00000060
#define UART_CONFIG_STOP_ONE 0x00000000
#define UART_CONFIG_PAR_NONE 0x00000000
#define UART_INT_RX 0x010
#define UART_INT_TX 0x020
#define UART_INT_RT 0x040

#define MAP_GPIOPinConfigure GPIOPinConfigure
#define MAP_GPIOPinTypeUART GPIOPinTypeUART
#define MAP_IntDisable IntDisable
#define MAP_IntEnable IntEnable
#define MAP_IntMasterEnable IntMasterEnable
#define MAP_SysCtlClockGet SysCtlClockGet
#define MAP_SysCtlPeripheralEnable SysCtlPeripheralEnable
#define MAP_SysCtlPeripheralReady SysCtlPeripheralReady
#define MAP_SysTickEnable SysTickEnable
#define MAP_SysTickIntEnable SysTickIntEnable
#define MAP_SysTickPeriodSet SysTickPeriodSet
#define MAP_UARTCharGetNonBlocking UARTCharGetNonBlocking
#define MAP_UARTCharPutNonBlocking UARTCharPutNonBlocking
#define MAP_UARTCharsAvail UARTCharsAvail
#define MAP_UARTConfigSetExpClk UARTConfigSetExpClk
#define MAP_UARTFIFOEnable UARTFIFOEnable
#define MAP_UARTIntClear UARTIntClear
#define MAP_UARTIntEnable UARTIntEnable
#define MAP_UARTIntStatus UARTIntStatus
#define MAP_UARTSpaceAvail UARTSpaceAvail

void GPIOPinConfigure(uint32_t pin_config);
void GPIOPinTypeUART(uint32_t port, uint8_t pins);
void IntDisable(uint32_t interrupt);
void IntEnable(uint32_t interrupt);
bool IntMasterEnable(void);
uint32_t SysCtlClockGet(void);
void SysCtlPeripheralEnable(uint32_t peripheral);
bool SysCtlPeripheralReady(uint32_t peripheral);
void SysTickEnable(void);
void SysTickIntEnable(void);
void SysTickIntRegister(void (*handler)(void));
void SysTickPeriodSet(uint32_t period);
int32_t UARTCharGetNonBlocking(uint32_t base);
bool UARTCharPutNonBlocking(uint32_t base, unsigned char data);
bool UARTCharsAvail(uint32_t base);
void UARTConfigSetExpClk(uint32_t base, uint32_t clock, uint32_t baud, uint32_t config);
void UARTFIFOEnable(uint32_t base);
void UARTIntClear(uint32_t base, uint32_t flags);
void UARTIntEnable(uint32_t base, uint32_t flags);
void UARTIntRegister(uint32_t base, void (*handler)(void));
uint32_t UARTIntStatus(uint32_t base, bool masked);
bool UARTSpaceAvail(uint32_t base);

#endif
